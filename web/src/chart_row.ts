// The three charts: population, energy, deaths.
import { LinkedChart, type Line } from './charts';
import { causeColour, stateColour, type Theme } from './colours';
import { words } from './format';
import type { Recording } from './recording';

/** Of recordings side by side. */
export const viewNames = ['A', 'B', 'C', 'D'];

export class ChartRow {
  private charts: LinkedChart[] = [];
  private step = 0;

  constructor(
    private readonly element: HTMLElement,
    private readonly recordings: Recording[],
    private readonly causes: string[],
    private readonly stateIndex: (name: string) => number,
    private readonly onSeek: (step: number) => void,
  ) {}

  draw(theme: Theme): void {
    for (const chart of this.charts) chart.destroy();
    const make = (title: string, lines: Line[]) => {
      const chart = new LinkedChart(title, lines, theme, this.onSeek, (step) => {
        for (const each of this.charts) each.show(this.step, step ?? this.step);
      });
      this.element.append(chart.element);
      return chart;
    };
    this.charts = [
      make('Cells by state', this.population()),
      make('Mean energy and ambrosia of a cell', this.energy(theme)),
      make('Deaths so far, by cause', this.deaths(theme)),
    ];
    this.resize();
  }

  resize(): void {
    for (const chart of this.charts) chart.resize();
  }

  show(step: number): void {
    this.step = step;
    for (const chart of this.charts) chart.show(step);
  }

  /** Lines of every recording; those of the second are dashed and numbered. */
  private lines(of: (recording: Recording) => Omit<Line, 'first' | 'dashed'>[]): Line[] {
    return this.recordings.flatMap((recording, r) =>
      of(recording).map((line) => ({
        ...line,
        label: this.recordings.length > 1 ? `${line.label} ${viewNames[r]}` : line.label,
        first: recording.timeline.step[0],
        dashed: r > 0,
      })),
    );
  }

  private population(): Line[] {
    const { timeline } = this.recordings[0];
    const backdrop = [...timeline.resources].slice(0, 1).map(([name, values]): Line => ({
      label: `${name} in the world`,
      colour: '#999999',
      first: timeline.step[0],
      values,
      backdrop: true,
    }));
    return [
      ...backdrop,
      ...this.lines(({ timeline }) =>
        [...timeline.population].map(([name, values]) => ({
          label: name,
          colour: stateColour(this.stateIndex(name)),
          values,
        })),
      ),
    ];
  }

  private energy(theme: Theme): Line[] {
    const colours = theme === 'dark' ? ['#3fc59a', '#e6b450'] : ['#00795a', '#a86f00'];
    return this.lines(({ timeline, header }) => [
      { label: 'energy', colour: colours[0], values: timeline.energy[header.own] },
      { label: 'ambrosia (right)', colour: colours[1], values: timeline.ambrosia[header.own], right: true },
    ]);
  }

  private deaths(theme: Theme): Line[] {
    return this.lines(({ timeline }) =>
      [...timeline.deaths].map(([name, values]) => ({
        label: words(name),
        colour: causeColour(this.causes.indexOf(name), theme),
        values,
      })),
    );
  }
}
