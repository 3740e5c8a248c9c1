// What colour a cell has, by the choice of the viewer.
import { cloneColour, levelColour, organismColour, stateColour, type Theme } from './colours';
import type { Attribute, CellName, Recording } from './recording';

/** "state", "clone", "organism", or the name of an attribute. */
export type ColourBy = string;

export interface Paint {
  colour(row: number): string;
  /** Entries for a legend of kinds; a continuous scale has none. */
  kinds: { colour: string; label: string }[];
  scale?: { low: number; high: number };
}

/** Least number of cells whose descendants are told apart as clones. */
const leastClones = 6;

/** The step of the first frame with enough cells to be founders of clones. */
export function defaultCloneStep(recording: Recording): number {
  const { rowStart, steps } = recording;
  for (let frame = 0; frame < recording.frames; ++frame)
    if (rowStart[frame + 1] - rowStart[frame] >= leastClones) return steps[frame];
  return recording.firstStep;
}

/** Numbers the cells that live at a step, and finds of any cell whose descendant it is. */
export class Clones {
  readonly count: number;
  private readonly known = new Map<number, number>();

  constructor(
    private readonly recording: Recording,
    readonly step: number,
  ) {
    const frame = recording.frameAt(step);
    const begin = recording.rowStart[frame];
    this.count = recording.rowStart[frame + 1] - begin;
    for (let i = 0; i < this.count; ++i)
      this.known.set(this.key(recording.organism[begin + i], recording.id[begin + i]), i);
  }

  /** -1: a descendant of none of them (it died before). */
  of(cell: CellName): number {
    const key = this.key(cell.organism, cell.id);
    const known = this.known.get(key);
    if (known !== undefined) return known;
    const ancestor = this.recording.ancestorAt(cell, this.step);
    const clone = this.known.get(this.key(ancestor.organism, ancestor.id)) ?? -1;
    this.known.set(key, clone);
    return clone;
  }

  private key(organism: number, id: number): number {
    return organism * 2 ** 32 + id;
  }
}

function paintAttribute(attribute: Attribute, range: { low: number; high: number }): Paint {
  const { values } = attribute;
  const { low, high } = range;
  const span = high > low ? high - low : 1;
  return {
    colour: (row) => levelColour((values[row] - low) / span),
    kinds: [],
    scale: { low, high },
  };
}

/** A scale that suits all recordings shown: from 0 (or the smallest, if below) to the largest. */
export function commonRange(attributes: (Attribute | undefined)[]): { low: number; high: number } {
  let low = 0;
  let high = -Infinity;
  for (const attribute of attributes) {
    if (!attribute) continue;
    low = Math.min(low, attribute.low);
    high = Math.max(high, attribute.high);
  }
  return { low, high: high > low ? high : low + 1 };
}

export function paintOf(
  recording: Recording,
  by: ColourBy,
  clones: Clones,
  stateIndex: (name: string) => number,
  range: { low: number; high: number },
  theme: Theme,
): Paint {
  const attribute = recording.attribute(by);
  if (attribute) return paintAttribute(attribute, range);
  if (by === 'clone')
    return {
      colour: (row) => {
        const clone = clones.of({ organism: recording.organism[row], id: recording.id[row] });
        return clone < 0 ? '#9a9a9a' : cloneColour(clone);
      },
      kinds: Array.from({ length: Math.min(clones.count, 12) }, (_, clone) => ({
        colour: cloneColour(clone),
        label: `clone ${clone + 1}`,
      })),
    };
  if (by === 'organism')
    return {
      colour: (row) => organismColour(recording.organism[row], theme),
      kinds: recording.header.organisms.map((_, o) => ({
        colour: organismColour(o, theme),
        label: recording.organismName(o),
      })),
    };
  const colours = recording.stateNames.map((name) => stateColour(stateIndex(name)));
  return {
    colour: (row) => colours[recording.stateAt(row)],
    kinds: recording.stateNames.map((name, s) => ({ colour: colours[s], label: name })),
  };
}
