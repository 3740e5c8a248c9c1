// The step that is shown, and how it moves with time.
export const speeds = [1, 2, 5, 10, 20, 30, 60, 120, 240, 480];

export class Player {
  step: number;
  playing = false;
  /** Steps a second. */
  speed = 30;
  private carried = 0;

  constructor(
    readonly first: number,
    readonly last: number,
  ) {
    this.step = first;
  }

  seek(step: number): void {
    this.step = Math.min(Math.max(Math.round(step), this.first), this.last);
    this.carried = 0;
  }

  /** Begins again when it stands at the end. */
  toggle(): void {
    if (!this.playing && this.step >= this.last) this.seek(this.first);
    this.playing = !this.playing;
    this.carried = 0;
  }

  faster(by: number): void {
    const at = speeds.findIndex((speed) => speed >= this.speed);
    this.speed = speeds[Math.min(Math.max((at < 0 ? 0 : at) + by, 0), speeds.length - 1)];
  }

  /** Time passed; returns whether the step is another. A long pause (a hidden tab) is no time. */
  advance(milliseconds: number): boolean {
    if (!this.playing) return false;
    this.carried += (Math.min(milliseconds, 250) * this.speed) / 1000;
    const steps = Math.floor(this.carried);
    if (steps === 0) return false;
    this.carried -= steps;
    this.step = Math.min(this.step + steps, this.last);
    if (this.step >= this.last) this.playing = false;
    return true;
  }
}
