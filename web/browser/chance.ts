// Random choices of tests, told so that they can be made again: SOMAS_WEB_SEED=N repeats them.

const seed = Number(process.env.SOMAS_WEB_SEED ?? Date.now() % 2 ** 31);

/** Numbers from 0 to below `end`, by mulberry32. */
export class Chance {
  private state = seed;

  constructor(purpose: string) {
    process.stdout.write(`${purpose}: SOMAS_WEB_SEED=${seed}\n`);
  }

  below(end: number): number {
    this.state = (this.state + 0x6d2b79f5) | 0;
    let t = Math.imul(this.state ^ (this.state >>> 15), 1 | this.state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return Math.floor((((t ^ (t >>> 14)) >>> 0) / 2 ** 32) * end);
  }
  of<T>(all: readonly T[]): T {
    return all[this.below(all.length)];
  }
  /** Different ones, ascending. */
  several(count: number, end: number): number[] {
    const chosen = new Set<number>();
    while (chosen.size < Math.min(count, end)) chosen.add(this.below(end));
    return [...chosen].sort((a, b) => a - b);
  }
}
