// Discs drawn once and copied for every cell: ten times as fast as drawing each.
import { mix, type Theme } from './colours';

/** 'plain' has no rim. */
export type Mark = 'plain' | 'none' | 'quiescence' | 'division' | 'specialization' | 'apoptosis';

export class Sprites {
  private readonly made = new Map<string, ImageBitmap>();
  private size = 0;
  private theme: Theme = 'light';

  /** Radius in pixels of the largest disc that will be asked for. */
  prepare(radius: number, theme: Theme): void {
    const size = Math.min(256, Math.max(8, 2 ** Math.ceil(Math.log2(2 * radius + 2))));
    if (size === this.size && theme === this.theme) return;
    this.size = size;
    this.theme = theme;
    this.made.clear();
  }

  /** A square picture; the disc touches its edges. */
  disc(colour: string, mark: Mark): ImageBitmap {
    const key = `${colour} ${mark}`;
    let sprite = this.made.get(key);
    if (!sprite) {
      sprite = this.draw(colour, mark);
      this.made.set(key, sprite);
    }
    return sprite;
  }

  // A bitmap: a canvas would be copied anew for every cell.
  private draw(colour: string, mark: Mark): ImageBitmap {
    const canvas = new OffscreenCanvas(this.size, this.size);
    this.paint(canvas.getContext('2d')!, colour, mark);
    return canvas.transferToImageBitmap();
  }

  private paint(c: OffscreenCanvasRenderingContext2D, colour: string, mark: Mark): void {
    const radius = this.size / 2;
    const dark = this.theme === 'dark';
    const ink = dark ? '#ffffff' : '#15181c';
    const rim = mark === 'division' ? 0.16 : 0.08;
    c.fillStyle = colour;
    c.beginPath();
    c.arc(radius, radius, radius * 0.97, 0, 2 * Math.PI);
    c.fill();
    if (mark === 'plain') return;
    c.lineWidth = rim * radius;
    c.strokeStyle = mark === 'division' ? ink : mix(colour, dark ? '#ffffff' : '#000000', 0.42);
    c.beginPath();
    c.arc(radius, radius, radius * (0.97 - rim / 2), 0, 2 * Math.PI);
    c.stroke();
    if (this.size < 16) return;
    c.strokeStyle = c.fillStyle = ink;
    c.lineWidth = 0.12 * radius;
    if (mark === 'apoptosis') this.cross(c, radius);
    if (mark === 'specialization') {
      c.beginPath();
      c.arc(radius, radius, 0.26 * radius, 0, 2 * Math.PI);
      c.fill();
    }
  }

  private cross(c: OffscreenCanvasRenderingContext2D, radius: number): void {
    const arm = 0.42 * radius;
    for (const slope of [-1, 1]) {
      c.beginPath();
      c.moveTo(radius - arm, radius - slope * arm);
      c.lineTo(radius + arm, radius + slope * arm);
      c.stroke();
    }
  }
}
