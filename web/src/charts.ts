// Charts over the steps of the life, linked with each other and with the step that is shown.
import uPlot from 'uplot';

import { h, swatch } from './dom';
import { number } from './format';
import type { Theme } from './colours';

// uPlot's enumeration exists as a type only.
// eslint-disable-next-line @typescript-eslint/no-unsafe-enum-assignment
const rightSide: uPlot.Axis.Side = 1;

export interface Line {
  label: string;
  colour: string;
  /** Told apart from the first recording's by dashes. */
  dashed?: boolean;
  /** By step from `first` on. */
  first: number;
  values: ArrayLike<number>;
  /** A grey area behind the lines, on a scale of its own. */
  backdrop?: boolean;
  /** On the right axis. */
  right?: boolean;
}

const looks = {
  light: { text: '#4a5158', grid: '#e3e6e9', backdrop: '#d5dade' },
  dark: { text: '#a9b2bb', grid: '#262c33', backdrop: '#343c45' },
};

/** One x for all lines: the steps of all of them. Where a line has none its value is null. */
export function alignLines(lines: Line[]): { steps: number[]; columns: (number | null)[][] } {
  const first = Math.min(...lines.map((line) => line.first));
  const end = Math.max(...lines.map((line) => line.first + line.values.length));
  const steps = Array.from({ length: Math.max(0, end - first) }, (_, i) => first + i);
  const columns = lines.map((line) =>
    steps.map((step) => {
      const at = step - line.first;
      return at >= 0 && at < line.values.length ? line.values[at] : null;
    }),
  );
  return { steps, columns };
}

export class LinkedChart {
  readonly element: HTMLElement;
  private readonly plot: HTMLElement;
  private readonly playhead: HTMLElement;
  private readonly values: HTMLElement[] = [];
  private readonly chart: uPlot | undefined;
  private readonly steps: number[];
  private readonly columns: (number | null)[][];
  private step = 0;

  constructor(
    title: string,
    private readonly lines: Line[],
    theme: Theme,
    onSeek: (step: number) => void,
    onHover: (step: number | undefined) => void,
  ) {
    const { steps, columns } = alignLines(lines);
    this.steps = steps;
    this.columns = columns;
    const legend = h('ul', { class: 'chart-legend' });
    for (const line of lines) {
      const value = h('span', { class: 'value', 'data-series': line.label });
      const mark = swatch(line.backdrop ? looks[theme].backdrop : line.colour);
      mark.style.setProperty('--line', line.colour);
      if (line.dashed) mark.classList.add('dashed');
      legend.append(h('li', {}, mark, `${line.label} `, value));
      this.values.push(value);
    }
    this.plot = h('div', { class: 'plot', role: 'img', 'aria-label': `Chart: ${title}, by step` });
    this.element = h('section', { class: 'chart', 'aria-label': title }, h('h2', {}, title), legend, this.plot);
    this.playhead = h('div', { class: 'playhead' });
    if (lines.length === 0) {
      this.plot.replaceWith(h('p', { class: 'empty' }, 'Nothing happened.'));
      return;
    }
    this.chart = new uPlot(this.options(theme, onHover), [steps, ...columns], this.plot);
    this.chart.over.append(this.playhead);
    this.followPointer(this.chart.over, onSeek);
  }

  resize(): void {
    const width = this.plot.clientWidth;
    const height = this.plot.clientHeight;
    if (this.chart && width > 0 && height > 0) this.chart.setSize({ width, height });
    this.show(this.step);
  }

  /** The step of the playhead and of the numbers in the legend. */
  show(step: number, read = step): void {
    this.step = step;
    if (!this.chart) return;
    this.playhead.style.transform = `translateX(${this.chart.valToPos(step, 'x')}px)`;
    const at = Math.min(Math.max(read - this.steps[0], 0), this.steps.length - 1);
    this.lines.forEach((_, l) => {
      const value = this.columns[l][at];
      this.values[l].textContent = value === null ? 'ended' : number(value);
    });
  }

  destroy(): void {
    this.chart?.destroy();
    this.element.remove();
  }

  private options(theme: Theme, onHover: (step: number | undefined) => void): uPlot.Options {
    const look = looks[theme];
    const axis = {
      stroke: look.text,
      font: '11px system-ui, sans-serif',
      grid: { stroke: look.grid, width: 1 },
      ticks: { stroke: look.grid, width: 1, size: 4 },
    };
    const right = this.lines.some((line) => line.right);
    return {
      width: 300,
      height: 120,
      padding: [8, right ? 0 : 12, 0, 0],
      legend: { show: false },
      cursor: { sync: { key: 'somas' }, drag: { x: false, y: false }, y: false, points: { size: 5 } },
      scales: {
        x: { time: false },
        y: { range: (_u, low, high) => [Math.min(0, low), high > 0 ? high * 1.06 : 1] },
        right: { range: (_u, low, high) => [Math.min(0, low), high > 0 ? high * 1.06 : 1] },
        backdrop: { range: (_u, _low, high) => [0, high > 0 ? high * 1.06 : 1] },
      },
      axes: [
        { ...axis, size: 24 },
        { ...axis, size: 44 },
        ...(right ? [{ ...axis, scale: 'right', side: rightSide, size: 40, grid: { show: false } }] : []),
      ],
      series: [
        {},
        ...this.lines.map((line) => ({
          scale: line.backdrop ? 'backdrop' : line.right ? 'right' : 'y',
          stroke: line.backdrop ? 'transparent' : line.colour,
          width: 1.75,
          dash: line.dashed ? [5, 3] : [],
          points: { show: false },
          ...(line.backdrop ? { fill: look.backdrop } : {}),
        })),
      ],
      hooks: {
        setCursor: [
          (u: uPlot) => {
            const index = u.cursor.idx;
            onHover(typeof index === 'number' ? this.steps[index] : undefined);
          },
        ],
      },
    };
  }

  private followPointer(over: HTMLElement, onSeek: (step: number) => void): void {
    const seek = (event: PointerEvent) => {
      const x = event.clientX - over.getBoundingClientRect().left;
      onSeek(Math.round(this.chart!.posToVal(x, 'x')));
    };
    over.addEventListener('pointerdown', (event) => {
      over.setPointerCapture(event.pointerId);
      seek(event);
    });
    over.addEventListener('pointermove', (event) => {
      if (event.buttons & 1) seek(event);
    });
  }
}
