// A picture of the stages as they are, with a caption.
import type { Theme } from './colours';

export interface Panel {
  title: string;
  caption: string;
  draw: (c: CanvasRenderingContext2D, width: number, height: number) => void;
}
export interface Legend {
  title: string;
  kinds: { colour: string; label: string }[];
  scale?: { low: string; high: string; colour: (share: number) => string };
}

const scale = 2; // pixels of the picture to a CSS pixel
const gap = 16;
const foot = 60;
const head = 44;

export function paintPicture(
  panels: Panel[],
  legend: Legend,
  size: { width: number; height: number },
  theme: Theme,
): HTMLCanvasElement {
  const canvas = document.createElement('canvas');
  const width = panels.length * size.width + (panels.length + 1) * gap;
  const height = size.height + head + foot;
  canvas.width = width * scale;
  canvas.height = height * scale;
  const c = canvas.getContext('2d')!;
  c.scale(scale, scale);
  c.fillStyle = theme === 'dark' ? '#0b0d10' : '#ffffff';
  c.fillRect(0, 0, width, height);
  panels.forEach((panel, p) => {
    const left = gap + p * (size.width + gap);
    c.save();
    c.translate(left, head);
    c.beginPath();
    c.rect(0, 0, size.width, size.height);
    c.clip();
    panel.draw(c, size.width, size.height);
    c.restore();
    c.fillStyle = theme === 'dark' ? '#f2f4f6' : '#15181c';
    c.textAlign = 'left';
    c.font = '600 15px system-ui, sans-serif';
    c.fillText(panel.title, left, 19, size.width);
    c.font = '12px system-ui, sans-serif';
    c.fillText(panel.caption, left, 36, size.width);
  });
  drawLegend(c, legend, head + size.height + 26, theme);
  return canvas;
}

function drawLegend(c: CanvasRenderingContext2D, legend: Legend, y: number, theme: Theme): void {
  const ink = theme === 'dark' ? '#f2f4f6' : '#15181c';
  let x = gap;
  const write = (text: string) => {
    c.fillStyle = ink;
    c.fillText(text, x, y);
    x += c.measureText(text).width + 14;
  };
  c.font = '600 13px system-ui, sans-serif';
  write(legend.title);
  c.font = '13px system-ui, sans-serif';
  for (const { colour, label } of legend.kinds) {
    c.fillStyle = colour;
    c.beginPath();
    c.arc(x + 6, y - 5, 6, 0, 2 * Math.PI);
    c.fill();
    x += 17;
    write(label);
  }
  if (!legend.scale) return;
  write(legend.scale.low);
  const length = 160;
  for (let i = 0; i < length; ++i) {
    c.fillStyle = legend.scale.colour(i / (length - 1));
    c.fillRect(x + i, y - 11, 1.5, 13);
  }
  x += length + 12;
  write(legend.scale.high);
}

export function download(name: string, blob: Blob): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => {
    URL.revokeObjectURL(link.href);
  }, 10_000);
}
