// A cell's life as lines: energy and pressure, ambrosia by its largest; states and actions below.
import { stateColour } from './colours';
import type { Recording } from './recording';

const lines: { name: string; dash: number[]; colour: string }[] = [
  { name: 'energy', dash: [], colour: '#009E73' },
  { name: 'pressure', dash: [4, 2], colour: '#CC79A7' },
  { name: 'ambrosia', dash: [1, 2], colour: '#E69F00' },
];
const actionColours: Record<string, string> = {
  quiescence: '#9aa3ad',
  division: '#D55E00',
  specialization: '#0072B2',
  apoptosis: '#7F3F98',
};

export function drawLife(
  canvas: HTMLCanvasElement,
  recording: Recording,
  life: { frame: number; row: number }[],
  frame: number,
  ink: string,
  stateIndex: (name: string) => number,
): void {
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  const ratio = window.devicePixelRatio;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const c = canvas.getContext('2d')!;
  c.scale(ratio, ratio);
  const x = (i: number) => (i / life.length) * width;
  const bottom = height - 34;

  c.font = '11px system-ui, sans-serif';
  lines.forEach(({ name, dash, colour }, n) => {
    const attribute = recording.attribute(name);
    if (!attribute) return;
    const high = name === 'ambrosia' ? Math.max(attribute.high, 1e-9) : 1;
    c.strokeStyle = colour;
    c.lineWidth = 1.75;
    c.setLineDash(dash);
    c.beginPath();
    life.forEach(({ row }, i) => {
      c.lineTo(x(i + 0.5), bottom - (attribute.values[row] / high) * (bottom - 18));
    });
    c.stroke();
    c.beginPath();
    c.moveTo(n * 92, 7);
    c.lineTo(n * 92 + 16, 7);
    c.stroke();
    c.fillStyle = ink;
    c.fillText(name, n * 92 + 21, 11);
  });
  c.setLineDash([]);

  life.forEach(({ row }, i) => {
    const state = recording.stateName(recording.organism[row], recording.state[row]);
    c.fillStyle = stateColour(stateIndex(state));
    c.fillRect(x(i), bottom + 6, x(1) + 0.6, 9);
    const action = actionColours[recording.actionName(row)];
    if (!action) return;
    c.fillStyle = action;
    c.fillRect(x(i), bottom + 19, x(1) + 0.6, 9);
  });

  const now = life.findIndex((at) => at.frame === frame);
  if (now < 0) return;
  c.fillStyle = ink;
  c.fillRect(x(now + 0.5) - 0.75, 16, 1.5, height - 16);
}
