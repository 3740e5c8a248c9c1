// Draws one recording at one step, from below: fields, the world, outlines, deaths, cells, contacts,
// tables, the selection.
import type { Camera } from './camera';
import { roundLength } from './camera';
import { causeColour, channels, fieldColour, organismColour, tableColour, type Theme } from './colours';
import { overlaps } from './contacts';
import { number } from './format';
import type { Paint } from './paint';
import type { CellName, Recording } from './recording';
import { Sprites, type Mark } from './sprites';

export interface Scene {
  frame: number;
  step: number;
  paint: Paint;
  layers: ReadonlySet<string>;
  selected: CellName | undefined;
  /** Draw all but the selected cell's descendants faintly. */
  family: boolean;
  theme: Theme;
}

const inks = {
  light: { ground: '#eceef0', world: '#ffffff', rim: '#8a9199', ink: '#15181c', outline: '#4b5157' },
  dark: { ground: '#0b0d10', world: '#15191f', rim: '#5c6670', ink: '#f2f4f6', outline: '#9aa3ad' },
};
/** Steps for which a death stays marked. */
const deathSteps = 12;

export const layerOfGrid = (name: string): string => `grid:${name}`;
export const layerOfOrganism = (organism: number): string => `organism:${organism}`;
export const layerOfTable = (name: string): string => `table:${name}`;

export class Stage {
  private readonly sprites = new Sprites();
  private readonly dots = new Sprites();
  private readonly fields = new Map<number, { key: string; picture: HTMLCanvasElement }>();

  constructor(
    readonly recording: Recording,
    readonly camera: Camera,
    private readonly causes: string[],
  ) {}

  /** Lengths are CSS pixels; the context is scaled to the screen's. */
  draw(c: CanvasRenderingContext2D, width: number, height: number, scene: Scene): void {
    const ink = inks[scene.theme];
    c.fillStyle = ink.ground;
    c.fillRect(0, 0, width, height);
    this.drawWorld(c, width, height, scene);
    this.drawOutlines(c, width, height, scene);
    if (scene.layers.has('deaths')) this.drawDeaths(c, width, height, scene);
    this.drawCells(c, width, height, scene);
    if (scene.layers.has('contacts')) this.drawContacts(c, width, height, scene);
    this.drawTables(c, width, height, scene);
    this.drawSelection(c, width, height, scene);
    this.drawScaleBar(c, height, scene);
  }

  /** The cell under a point of the stage, the nearest centre first. */
  pick(px: number, py: number, width: number, height: number, frame: number): CellName | undefined {
    const { x, y, radius, organism, id, rowStart } = this.recording;
    const [wx, wy] = this.camera.toWorld(px, py, width, height);
    const slack = 3 / this.camera.scale;
    let best = -1;
    let nearest = Infinity;
    for (let row = rowStart[frame]; row < rowStart[frame + 1]; ++row) {
      const distance = Math.hypot(x[row] - wx, y[row] - wy);
      if (distance <= radius[row] + slack && distance < nearest) {
        nearest = distance;
        best = row;
      }
    }
    return best < 0 ? undefined : { organism: organism[best], id: id[best] };
  }

  private disc(
    c: CanvasRenderingContext2D,
    [px, py]: [number, number],
    radius: number,
  ): void {
    c.beginPath();
    c.arc(px, py, radius, 0, 2 * Math.PI);
  }

  private drawWorld(c: CanvasRenderingContext2D, width: number, height: number, scene: Scene): void {
    const ink = inks[scene.theme];
    const centre = this.camera.toScreen(0, 0, width, height);
    const radius = this.recording.header.radius * this.camera.scale;
    this.disc(c, centre, radius);
    c.fillStyle = ink.world;
    c.fill();
    c.save();
    c.clip();
    this.drawFields(c, width, height, scene);
    c.restore();
    this.disc(c, centre, radius);
    c.strokeStyle = ink.rim;
    c.lineWidth = 1.5;
    c.stroke();
  }

  private drawFields(c: CanvasRenderingContext2D, width: number, height: number, scene: Scene): void {
    const field = this.recording.fieldFrame(scene.frame);
    if (field < 0) return;
    c.imageSmoothingEnabled = false;
    this.recording.header.grids.forEach((grid, g) => {
      if (!scene.layers.has(layerOfGrid(grid.name))) return;
      const [left, top] = this.camera.toScreen(
        grid.left,
        grid.bottom + grid.rows * grid.side,
        width,
        height,
      );
      const scale = grid.side * this.camera.scale;
      c.drawImage(
        this.fieldPicture(g, field, scene.theme),
        left,
        top,
        grid.columns * scale,
        grid.rows * scale,
      );
    });
    c.imageSmoothingEnabled = true;
  }

  private fieldPicture(g: number, field: number, theme: Theme): HTMLCanvasElement {
    const key = `${field} ${theme}`;
    const known = this.fields.get(g);
    if (known?.key === key) return known.picture;
    const { columns, rows } = this.recording.header.grids[g];
    const picture = known?.picture ?? document.createElement('canvas');
    picture.width = columns;
    picture.height = rows;
    const context = picture.getContext('2d')!;
    const image = context.createImageData(columns, rows);
    const [red, green, blue] = channels(fieldColour(g, theme));
    const bytes = this.recording.grid(g, field);
    // What all may eat is only the ground that the cells stand on.
    const strength = this.recording.header.grids[g].resource ? 0.3 : 0.5;
    for (let row = 0; row < rows; ++row)
      for (let column = 0; column < columns; ++column) {
        const at = 4 * ((rows - 1 - row) * columns + column);
        image.data[at] = red;
        image.data[at + 1] = green;
        image.data[at + 2] = blue;
        image.data[at + 3] = bytes[row * columns + column] * strength;
      }
    context.putImageData(image, 0, 0);
    this.fields.set(g, { key, picture });
    return picture;
  }

  private drawOutlines(c: CanvasRenderingContext2D, width: number, height: number, scene: Scene): void {
    if (!scene.layers.has('outlines')) return;
    c.strokeStyle = inks[scene.theme].outline;
    c.lineWidth = 1.5;
    for (const outline of this.recording.header.outlines) {
      c.beginPath();
      outline.x.forEach((x, i) => {
        c.lineTo(...this.camera.toScreen(x, outline.y[i], width, height));
      });
      if (outline.closed) {
        c.closePath();
        c.fillStyle = inks[scene.theme].outline + '40';
        c.fill();
      }
      c.stroke();
    }
  }

  private drawCells(c: CanvasRenderingContext2D, width: number, height: number, scene: Scene): void {
    if (!scene.layers.has('cells')) return;
    const { x, y, radius, rowStart, organism, id } = this.recording;
    const scale = this.camera.scale;
    const ratio = c.getTransform().a;
    this.sprites.prepare(1.5 * scale * ratio, scene.theme);
    const marked = scene.layers.has('actions');
    const family = scene.family ? scene.selected : undefined;
    const begin = rowStart[scene.frame];
    for (let row = begin; row < rowStart[scene.frame + 1]; ++row) {
      if (row === begin || organism[row] !== organism[row - 1]) this.surround(c, width, height, scene, row);
      const r = radius[row] * scale;
      const [px, py] = this.camera.toScreen(x[row], y[row], width, height);
      if (px + r < 0 || px - r > width || py + r < 0 || py - r > height) continue;
      const mark = marked ? (this.recording.actionName(row) as Mark) : 'none';
      if (family) {
        const kin = this.recording.isDescendant({ organism: organism[row], id: id[row] }, family);
        c.globalAlpha = kin ? 1 : 0.18;
      }
      c.drawImage(this.sprites.disc(scene.paint.colour(row), mark), px - r, py - r, 2 * r, 2 * r);
    }
    c.globalAlpha = 1;
  }

  /** A little more than all cells of an organism, which are drawn over it: its outline. */
  private surround(c: CanvasRenderingContext2D, width: number, height: number, scene: Scene, first: number): void {
    const { x, y, radius, rowStart, organism } = this.recording;
    if (!scene.layers.has(layerOfOrganism(organism[first]))) return;
    const rim = Math.max(2, 0.25 * this.camera.scale);
    c.beginPath();
    for (let row = first; row < rowStart[scene.frame + 1] && organism[row] === organism[first]; ++row) {
      const [px, py] = this.camera.toScreen(x[row], y[row], width, height);
      const r = radius[row] * this.camera.scale + rim;
      c.moveTo(px + r, py);
      c.arc(px, py, r, 0, 2 * Math.PI);
    }
    c.globalAlpha = 1;
    c.fillStyle = organismColour(organism[first], scene.theme);
    c.fill();
  }

  private drawContacts(c: CanvasRenderingContext2D, width: number, height: number, scene: Scene): void {
    const { x, y, radius, rowStart } = this.recording;
    c.beginPath();
    overlaps(x, y, radius, rowStart[scene.frame], rowStart[scene.frame + 1], (i, j) => {
      c.moveTo(...this.camera.toScreen(x[i], y[i], width, height));
      c.lineTo(...this.camera.toScreen(x[j], y[j], width, height));
    });
    c.strokeStyle = inks[scene.theme].ink + '99';
    c.lineWidth = 1;
    c.stroke();
  }

  private drawTables(c: CanvasRenderingContext2D, width: number, height: number, scene: Scene): void {
    this.recording.header.tables.forEach((name, t) => {
      if (!scene.layers.has(layerOfTable(name))) return;
      const { x, y } = this.recording.table(t, scene.frame);
      const radius = Math.max(1.5, 0.22 * this.camera.scale);
      // Stamped: one path of hundreds of circles takes many times as long to fill.
      this.dots.prepare(radius * c.getTransform().a, scene.theme);
      const dot = this.dots.disc(tableColour(t, scene.theme), 'plain');
      for (let i = 0; i < x.length; ++i) {
        const [px, py] = this.camera.toScreen(x[i], y[i], width, height);
        if (px + radius < 0 || px - radius > width || py + radius < 0 || py - radius > height) continue;
        c.drawImage(dot, px - radius, py - radius, 2 * radius, 2 * radius);
      }
    });
  }

  private drawDeaths(c: CanvasRenderingContext2D, width: number, height: number, scene: Scene): void {
    const { events } = this.recording;
    const arm = Math.max(3, 0.45 * this.camera.scale);
    c.lineWidth = Math.max(1.25, 0.12 * this.camera.scale);
    let event = this.recording.firstEvent(Math.max(0, scene.step - deathSteps + 1));
    for (; event < events.step.length && events.step[event] <= scene.step; ++event) {
      if (this.recording.eventKind(event) !== 'death') continue;
      const [px, py] = this.camera.toScreen(events.x[event], events.y[event], width, height);
      const cause = this.causes.indexOf(this.recording.causeName(events.cause[event]));
      c.globalAlpha = 1 - (scene.step - events.step[event]) / deathSteps;
      c.strokeStyle = causeColour(cause, scene.theme);
      c.beginPath();
      c.moveTo(px - arm, py - arm);
      c.lineTo(px + arm, py + arm);
      c.moveTo(px - arm, py + arm);
      c.lineTo(px + arm, py - arm);
      c.stroke();
    }
    c.globalAlpha = 1;
  }

  private drawSelection(c: CanvasRenderingContext2D, width: number, height: number, scene: Scene): void {
    if (!scene.selected) return;
    const row = this.recording.rowOf(scene.frame, scene.selected);
    if (row < 0) return;
    const { x, y, radius } = this.recording;
    const at = (r: number) => this.camera.toScreen(x[r], y[r], width, height);
    const ring = (r: number, gap: number) => {
      this.disc(c, at(r), radius[r] * this.camera.scale + gap);
      c.stroke();
    };
    c.strokeStyle = inks[scene.theme].ink;
    c.lineWidth = 1.5;
    const mother = this.recording.motherOf(scene.selected);
    const kin = [...this.recording.daughtersOf(scene.selected), ...(mother ? [mother] : [])];
    for (const cell of kin) {
      const other = this.recording.rowOf(scene.frame, cell);
      if (other < 0) continue;
      c.setLineDash(cell === mother ? [2, 3] : []);
      ring(other, 2);
      c.beginPath();
      c.moveTo(...at(row));
      c.lineTo(...at(other));
      c.stroke();
    }
    c.setLineDash([]);
    c.lineWidth = 3;
    ring(row, 4);
  }

  private drawScaleBar(c: CanvasRenderingContext2D, height: number, scene: Scene): void {
    const length = roundLength(120 / this.camera.scale);
    const pixels = length * this.camera.scale;
    const y = height - 16;
    c.fillStyle = inks[scene.theme].ground + 'd8';
    c.fillRect(8, y - 22, Math.max(pixels, 60) + 20, 32);
    c.strokeStyle = c.fillStyle = inks[scene.theme].ink;
    c.lineWidth = 2;
    c.beginPath();
    c.moveTo(18, y - 4);
    c.lineTo(18, y);
    c.lineTo(18 + pixels, y);
    c.lineTo(18 + pixels, y - 4);
    c.stroke();
    c.font = '12px system-ui, sans-serif';
    c.textAlign = 'left';
    c.fillText(`${number(length)} ${length === 1 ? 'unit' : 'units'}`, 18, y - 8);
  }
}

/** Around all cells of a recording, over its life (every tenth frame). */
export function extentOf(recording: Recording): {
  left: number;
  right: number;
  bottom: number;
  top: number;
} {
  const { x, y, rowStart, frames } = recording;
  const box = { left: Infinity, right: -Infinity, bottom: Infinity, top: -Infinity };
  for (let frame = 0; frame < frames; frame += 10)
    for (let row = rowStart[frame]; row < rowStart[frame + 1]; ++row) {
      box.left = Math.min(box.left, x[row] - 1.5);
      box.right = Math.max(box.right, x[row] + 1.5);
      box.bottom = Math.min(box.bottom, y[row] - 1.5);
      box.top = Math.max(box.top, y[row] + 1.5);
    }
  return box.left <= box.right ? box : { left: -5, right: 5, bottom: -5, top: 5 };
}
