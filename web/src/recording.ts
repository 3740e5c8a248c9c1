// A recorded life, as the page asks about it.
import type { Column, Pack } from './pack';

export interface StateHeader {
  name: string;
  parent: number | null;
}
export interface OrganismHeader {
  states: StateHeader[];
  outputs: string[];
}
export interface GridHeader {
  name: string;
  columns: number;
  rows: number;
  side: number;
  left: number;
  bottom: number;
  /** What a byte of 0 and of 255 stands for. */
  low: number;
  high: number;
  /** Of a morphogen: whose. */
  organism?: number;
  resource?: string;
}
export interface OutlineHeader {
  name: string;
  closed: boolean;
  x: number[];
  y: number[];
}
export interface Header {
  title: string;
  subtitle: string;
  /** What a what-if changed. */
  changes: string[];
  radius: number;
  max_steps: number;
  every: number;
  own: number;
  survival: number;
  censored: boolean;
  organisms: OrganismHeader[];
  actions: string[];
  causes: string[];
  grids: GridHeader[];
  tables: string[];
  outlines: OutlineHeader[];
  /** Continuous columns of cells, in the order to show them. */
  attributes: AttributeHeader[];
}
export type AttributeGroup = 'cell' | 'damage' | 'value' | 'input' | 'output';
export interface AttributeHeader {
  name: string;
  group: AttributeGroup;
  column: string;
}
export interface Attribute extends AttributeHeader {
  values: Float32Array;
  low: number;
  high: number;
}

export type EventKind = 'birth' | 'death' | 'refused_division' | 'specialization';
const eventKinds: EventKind[] = ['birth', 'death', 'refused_division', 'specialization'];
export const noIndex = 0xffff;

/** A cell for life. */
export interface CellName {
  organism: number;
  id: number;
}
export interface Daughter extends CellName {
  born: number;
}
export interface Death {
  step: number;
  cause: string;
}

/** Columns, one value a step of the life. */
export interface Timeline {
  step: number[];
  population: Map<string, number[]>;
  energy: number[][];
  ambrosia: number[][];
  deaths: Map<string, number[]>;
  resources: Map<string, number[]>;
}

const key = (organism: number, id: number): number => organism * 2 ** 32 + id;

export class Recording {
  readonly header: Header;
  readonly steps: Uint32Array;
  readonly rowStart: Uint32Array;
  readonly id: Uint32Array;
  readonly organism: Uint16Array;
  readonly parent: Uint32Array;
  readonly born: Uint32Array;
  readonly state: Uint16Array;
  readonly action: Uint8Array;
  readonly x: Float32Array;
  readonly y: Float32Array;
  readonly radius: Float32Array;
  readonly attributes: Attribute[];
  readonly previous: Int32Array;
  /** Names of states over all organisms: a name is a state. */
  readonly stateNames: string[] = [];
  readonly timeline: Timeline;
  readonly events: {
    step: Uint32Array;
    kind: Uint8Array;
    organism: Uint16Array;
    cell: Uint32Array;
    parent: Uint32Array;
    state: Uint16Array;
    cause: Uint16Array;
    x: Float32Array;
    y: Float32Array;
  };

  private readonly stateIndex: number[][] = [];
  private readonly deathOf = new Map<number, Death>();
  private readonly birthOf = new Map<number, { parent: number; step: number }>();
  private readonly daughters = new Map<number, Daughter[]>();

  constructor(private readonly pack: Pack) {
    this.header = pack.header as unknown as Header;
    const u32 = (name: string) => this.column(name) as Uint32Array;
    const u16 = (name: string) => this.column(name) as Uint16Array;
    const f32 = (name: string) => this.column(name) as Float32Array;
    this.steps = u32('frame.step');
    this.rowStart = u32('frame.rows');
    this.id = u32('cell.id');
    this.organism = u16('cell.organism');
    this.parent = u32('cell.parent');
    this.born = u32('cell.born');
    this.state = u16('cell.state');
    this.action = this.column('cell.action') as Uint8Array;
    this.x = f32('cell.x');
    this.y = f32('cell.y');
    this.radius = f32('cell.radius');
    this.previous = pack.previous;
    this.events = {
      step: u32('event.step'),
      kind: this.column('event.kind') as Uint8Array,
      organism: u16('event.organism'),
      cell: u32('event.cell'),
      parent: u32('event.parent'),
      state: u16('event.state'),
      cause: u16('event.cause'),
      x: f32('event.x'),
      y: f32('event.y'),
    };
    this.attributes = this.header.attributes.map((attribute) => {
      const values = f32(attribute.column);
      return { ...attribute, values, ...rangeOf(values) };
    });
    this.nameStates();
    this.indexEvents();
    this.timeline = this.readTimeline();
  }

  column(name: string): Column {
    const column = this.pack.columns.get(name);
    if (!column) throw new Error(`the recording has no column ${name}`);
    return column;
  }

  get frames(): number {
    return this.steps.length;
  }
  get firstStep(): number {
    return this.steps[0];
  }
  get lastStep(): number {
    return this.steps[this.steps.length - 1];
  }

  /** The last frame at or before a step; the first one if there is none. */
  frameAt(step: number): number {
    let low = 0;
    let high = this.steps.length;
    while (low + 1 < high) {
      const middle = (low + high) >> 1;
      if (this.steps[middle] <= step) low = middle;
      else high = middle;
    }
    return low;
  }

  /** The row of a cell in a frame, or -1. */
  rowOf(frame: number, cell: CellName): number {
    let low = this.rowStart[frame];
    let high = this.rowStart[frame + 1];
    while (low < high) {
      const middle = (low + high) >> 1;
      const before =
        this.organism[middle] < cell.organism ||
        (this.organism[middle] === cell.organism && this.id[middle] < cell.id);
      if (before) low = middle + 1;
      else high = middle;
    }
    const found =
      low < this.rowStart[frame + 1] &&
      this.organism[low] === cell.organism &&
      this.id[low] === cell.id;
    return found ? low : -1;
  }

  /** Frames and rows in which a cell lives, ascending. */
  lifeOf(cell: CellName): { frame: number; row: number }[] {
    const life: { frame: number; row: number }[] = [];
    for (let frame = this.frameAt(this.birthStep(cell)); frame < this.frames; ++frame) {
      const row = this.rowOf(frame, cell);
      if (row >= 0) life.push({ frame, row });
      else if (life.length > 0) break;
    }
    return life;
  }

  /** Index into `stateNames`. */
  stateAt(row: number): number {
    return this.stateIndex[this.organism[row]][this.state[row]];
  }
  stateName(organism: number, state: number): string {
    return this.header.organisms[organism].states[state].name;
  }
  organismName(organism: number): string {
    return `organism ${organism + 1}${organism === this.header.own ? ' (this champion)' : ''}`;
  }
  actionName(row: number): string {
    return this.header.actions[this.action[row]];
  }
  attribute(name: string): Attribute | undefined {
    return this.attributes.find((attribute) => attribute.name === name);
  }

  birthStep(cell: CellName): number {
    return this.birthOf.get(key(cell.organism, cell.id))?.step ?? this.firstStep;
  }
  /** Nothing for a founder, and for a cell that lived when the recording began. */
  motherOf(cell: CellName): CellName | undefined {
    const birth = this.birthOf.get(key(cell.organism, cell.id));
    return birth && { organism: cell.organism, id: birth.parent };
  }
  daughtersOf(cell: CellName): Daughter[] {
    return this.daughters.get(key(cell.organism, cell.id)) ?? [];
  }
  death(cell: CellName): Death | undefined {
    return this.deathOf.get(key(cell.organism, cell.id));
  }

  /** The ancestor that lived at a step: itself, if it did. */
  ancestorAt(cell: CellName, step: number): CellName {
    let ancestor = cell;
    for (;;) {
      const birth = this.birthOf.get(key(ancestor.organism, ancestor.id));
      if (!birth || birth.step <= step) return ancestor;
      ancestor = { organism: ancestor.organism, id: birth.parent };
    }
  }
  isDescendant(cell: CellName, of: CellName): boolean {
    if (cell.organism !== of.organism) return false;
    let ancestor: CellName | undefined = cell;
    while (ancestor && ancestor.id > of.id) ancestor = this.motherOf(ancestor);
    return ancestor?.id === of.id;
  }

  /** Points of a table in a frame. */
  table(index: number, frame: number): { x: Float32Array; y: Float32Array } {
    const rows = this.column(`table.${index}.rows`) as Uint32Array;
    const part = (name: string) =>
      (this.column(`table.${index}.${name}`) as Float32Array).subarray(rows[frame], rows[frame + 1]);
    return { x: part('x'), y: part('y') };
  }

  /** Which of the frames with fields holds at a frame; -1 before the first. */
  fieldFrame(frame: number): number {
    return (this.column('frame.fields') as Uint32Array)[frame] - 1;
  }
  /** Bytes of a grid, row-major from the lower left. */
  grid(index: number, fieldFrame: number): Uint8Array {
    const { columns, rows } = this.header.grids[index];
    const size = columns * rows;
    const all = this.column(`grid.${index}`) as Uint8Array;
    return all.subarray(fieldFrame * size, (fieldFrame + 1) * size);
  }

  eventKind(event: number): EventKind {
    return eventKinds[this.events.kind[event]];
  }
  causeName(cause: number): string {
    return cause === noIndex ? 'wound' : this.header.causes[cause];
  }
  /** The first event at or after a step. */
  firstEvent(step: number): number {
    let low = 0;
    let high = this.events.step.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.events.step[middle] < step) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  private nameStates(): void {
    for (const organism of this.header.organisms)
      this.stateIndex.push(
        organism.states.map(({ name }) => {
          if (!this.stateNames.includes(name)) this.stateNames.push(name);
          return this.stateNames.indexOf(name);
        }),
      );
  }

  private indexEvents(): void {
    const { step, organism, cell, parent, cause } = this.events;
    for (let i = 0; i < step.length; ++i) {
      const kind = this.eventKind(i);
      if (kind === 'death')
        this.deathOf.set(key(organism[i], cell[i]), {
          step: step[i],
          cause: this.causeName(cause[i]),
        });
      if (kind !== 'birth') continue;
      this.birthOf.set(key(organism[i], cell[i]), { parent: parent[i], step: step[i] });
      const mother = key(organism[i], parent[i]);
      const daughter = { organism: organism[i], id: cell[i], born: step[i] };
      const sisters = this.daughters.get(mother);
      if (sisters) sisters.push(daughter);
      else this.daughters.set(mother, [daughter]);
    }
  }

  private readTimeline(): Timeline {
    const step = Array.from(this.column('summary.step'));
    const population = new Map<string, number[]>(
      this.stateNames.map((name) => [name, new Array<number>(step.length).fill(0)]),
    );
    this.header.organisms.forEach((organism, o) => {
      organism.states.forEach((state, s) => {
        const counts = this.column(`summary.population.${o}.${s}`);
        const sum = population.get(state.name)!;
        for (let i = 0; i < step.length; ++i) sum[i] += counts[i];
      });
    });
    const means = (name: string) =>
      this.header.organisms.map((_, o) => Array.from(this.column(`summary.${name}.${o}`)));
    const resources = new Map<string, number[]>();
    this.header.grids.forEach((grid, g) => {
      if (grid.resource) resources.set(grid.resource, Array.from(this.column(`summary.grid.${g}`)));
    });
    return {
      step,
      population,
      energy: means('energy'),
      ambrosia: means('ambrosia'),
      deaths: this.countDeaths(step),
      resources,
    };
  }

  /** Deaths so far, by cause; only causes that killed. */
  private countDeaths(steps: number[]): Map<string, number[]> {
    const deaths = new Map<string, number[]>();
    const { step, cause } = this.events;
    let event = 0;
    steps.forEach((now, i) => {
      for (const counts of deaths.values()) counts[i] = i > 0 ? counts[i - 1] : 0;
      for (; event < step.length && step[event] <= now; ++event) {
        if (this.eventKind(event) !== 'death') continue;
        const name = this.causeName(cause[event]);
        let counts = deaths.get(name);
        if (!counts) {
          counts = new Array<number>(steps.length).fill(0);
          deaths.set(name, counts);
        }
        ++counts[i];
      }
    });
    return deaths;
  }
}

/** Smallest and largest of the numbers; 0 to 1 where there are none. */
export function rangeOf(values: Float32Array): { low: number; high: number } {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? { low, high } : { low: 0, high: 1 };
}
