// All that is known of one cell at the step shown.
import { scaleColour, stateColour } from './colours';
import { h, swatch } from './dom';
import { number, plural, words } from './format';
import type { CellName, Recording } from './recording';
import { drawLife } from './sparkline';

const mostChips = 24;

export interface InspectorActions {
  select(cell: CellName): void;
  seek(step: number): void;
}

export class Inspector {
  private shown = '';
  private life: { frame: number; row: number }[] = [];

  constructor(
    private readonly element: HTMLElement,
    private readonly actions: InspectorActions,
    private readonly stateIndex: (name: string) => number,
  ) {}

  clear(): void {
    this.shown = '';
    this.element.replaceChildren(
      h('p', { class: 'hint' }, 'Click a cell, or press n, to see its history, its controller and its family.'),
    );
  }

  show(recording: Recording, view: number, cell: CellName, frame: number, ink: string): void {
    const name = `${view} ${cell.organism} ${cell.id}`;
    if (name !== this.shown) {
      this.shown = name;
      this.life = recording.lifeOf(cell);
    }
    const row = recording.rowOf(frame, cell);
    this.element.replaceChildren(
      this.heading(recording, cell, row, recording.steps[frame]),
      ...(row >= 0 ? [this.facts(recording, row, recording.steps[frame])] : []),
      ...this.history(recording, frame, ink),
      ...(row >= 0 ? this.bars(recording, row) : []),
      this.family(recording, cell, frame),
    );
  }

  private heading(recording: Recording, cell: CellName, row: number, step: number): HTMLElement {
    const death = recording.death(cell);
    const born = recording.birthStep(cell);
    let status = 'not born yet';
    if (row >= 0) {
      const state = recording.stateName(cell.organism, recording.state[row]);
      return h(
        'h3',
        {},
        swatch(stateColour(this.stateIndex(state))),
        `Cell ${cell.id} `,
        h('span', { class: 'muted', 'data-field': 'state' }, state),
      );
    }
    if (death && death.step <= step) status = `died at step ${death.step}: ${words(death.cause)}`;
    else if (born > step) status = `born at step ${born}`;
    return h('h3', {}, `Cell ${cell.id} `, h('span', { class: 'muted' }, status));
  }

  private facts(recording: Recording, row: number, step: number): HTMLElement {
    const list = h('dl', { class: 'facts' });
    const fact = (label: string, field: string, text: string, exact: number | string) => {
      list.append(
        h('dt', {}, label),
        h('dd', { 'data-field': field, 'data-value': String(exact), title: String(exact) }, text),
      );
    };
    const action = recording.actionName(row);
    fact('action', 'action', words(action), action);
    fact('age', 'age', plural(step - recording.born[row], 'step'), step - recording.born[row]);
    const along = (field: 'x' | 'y') =>
      h(
        'span',
        { 'data-field': field, 'data-value': String(recording[field][row]), title: String(recording[field][row]) },
        number(recording[field][row]),
      );
    list.append(h('dt', {}, 'position'), h('dd', {}, along('x'), ', ', along('y')));
    fact('radius', 'radius', number(recording.radius[row]), recording.radius[row]);
    for (const attribute of recording.attributes)
      if (attribute.group !== 'output')
        fact(words(attribute.name), attribute.name, number(attribute.values[row]), attribute.values[row]);
    return list;
  }

  private history(recording: Recording, frame: number, ink: string): HTMLElement[] {
    if (this.life.length < 2) return [];
    const canvas = h('canvas', {
      class: 'life',
      role: 'img',
      'aria-label': 'Energy, pressure and ambrosia over the life of the cell, its states and actions below',
    });
    canvas.addEventListener('click', (event) => {
      const share = event.offsetX / canvas.clientWidth;
      const at = Math.min(Math.floor(share * this.life.length), this.life.length - 1);
      this.actions.seek(recording.steps[this.life[at].frame]);
    });
    requestAnimationFrame(() => {
      drawLife(canvas, recording, this.life, frame, ink, this.stateIndex);
    });
    return [h('h4', {}, 'History'), canvas];
  }

  private bars(recording: Recording, row: number): HTMLElement[] {
    const names = recording.header.organisms[recording.organism[row]].outputs;
    const outputs = recording.attributes.filter(({ group }) => group === 'output');
    const list = h('dl', { class: 'bars' });
    for (const [channel, name] of names.entries()) {
      const value = outputs[channel].values[row];
      const share = Number.isNaN(value) ? 0 : Math.min(Math.max(value, 0), 1);
      const bar = h('span', { class: 'bar', 'aria-hidden': 'true' });
      bar.style.width = `${100 * share}%`;
      bar.style.background = scaleColour(0.15 + 0.7 * share);
      list.append(
        h('dt', {}, words(name)),
        h(
          'dd',
          { 'data-field': `output ${name}`, 'data-value': String(value), title: String(value) },
          h('span', { class: 'track' }, bar),
          h('span', { class: 'value' }, number(value)),
        ),
      );
    }
    return list.childElementCount > 0 ? [h('h4', {}, 'Controller outputs'), list] : [];
  }

  private family(recording: Recording, cell: CellName, frame: number): HTMLElement {
    const chip = (other: CellName) => {
      const death = recording.death(other);
      const lives = recording.rowOf(frame, other) >= 0;
      const gone = !lives && death && death.step <= recording.steps[frame];
      const title = gone ? `died at step ${death.step}: ${words(death.cause)}` : lives ? 'alive' : 'not born yet';
      return h(
        'button',
        {
          type: 'button',
          class: lives ? 'chip' : 'chip gone',
          title,
          click: () => {
            this.actions.select(other);
          },
        },
        `${other.id}${gone ? ' †' : ''}`,
      );
    };
    const mother = recording.motherOf(cell);
    const daughters = recording.daughtersOf(cell);
    const more = daughters.length - mostChips;
    return h(
      'div',
      { class: 'family' },
      h('h4', {}, 'Family'),
      h('p', {}, 'mother ', mother ? chip(mother) : 'none: a founder'),
      h(
        'p',
        {},
        `${plural(daughters.length, 'daughter')} `,
        ...daughters.slice(0, mostChips).map(chip),
        more > 0 ? ` and ${more} more` : '',
      ),
    );
  }
}
