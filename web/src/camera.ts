// Where a stage looks: the centre in the world's lengths, and how many pixels one of them is.
export interface Box {
  left: number;
  right: number;
  bottom: number;
  top: number;
}

export class Camera {
  x = 0;
  y = 0;
  scale = 4;

  constructor(
    readonly least = 0.5,
    readonly most = 200,
  ) {}

  toScreen(x: number, y: number, width: number, height: number): [number, number] {
    return [width / 2 + (x - this.x) * this.scale, height / 2 - (y - this.y) * this.scale];
  }
  toWorld(px: number, py: number, width: number, height: number): [number, number] {
    return [this.x + (px - width / 2) / this.scale, this.y - (py - height / 2) / this.scale];
  }

  pan(dx: number, dy: number): void {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
  }

  /** The point of the world under (px, py) stays there. */
  zoom(factor: number, px: number, py: number, width: number, height: number): void {
    const [x, y] = this.toWorld(px, py, width, height);
    this.scale = Math.min(Math.max(this.scale * factor, this.least), this.most);
    this.x = x - (px - width / 2) / this.scale;
    this.y = y + (py - height / 2) / this.scale;
  }

  /** Shows the box with a margin. */
  fit(box: Box, width: number, height: number, margin = 1.15): void {
    this.x = (box.left + box.right) / 2;
    this.y = (box.bottom + box.top) / 2;
    const scale = Math.min(
      width / Math.max((box.right - box.left) * margin, 1e-6),
      height / Math.max((box.top - box.bottom) * margin, 1e-6),
    );
    this.scale = Math.min(Math.max(scale, this.least), this.most);
  }
}

/** The largest of 1, 2, 5, 10, ... (or 0.5, 0.2, ...) that is not above `most`. */
export function roundLength(most: number): number {
  const power = 10 ** Math.floor(Math.log10(most));
  for (const factor of [5, 2]) if (factor * power <= most) return factor * power;
  return power;
}
