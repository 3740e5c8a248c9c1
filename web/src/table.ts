// The cells of a step in rows: what a screen reader can read and a spreadsheet can take.
import { h } from './dom';
import { number } from './format';
import type { Recording } from './recording';

interface Column {
  name: string;
  value: (row: number) => number | string;
}

export function columnsOf(recording: Recording): Column[] {
  return [
    { name: 'organism', value: (row) => recording.organism[row] },
    { name: 'cell', value: (row) => recording.id[row] },
    { name: 'mother', value: (row) => recording.parent[row] },
    { name: 'born', value: (row) => recording.born[row] },
    { name: 'state', value: (row) => recording.stateName(recording.organism[row], recording.state[row]) },
    { name: 'action', value: (row) => recording.actionName(row) },
    { name: 'x', value: (row) => recording.x[row] },
    { name: 'y', value: (row) => recording.y[row] },
    { name: 'radius', value: (row) => recording.radius[row] },
    ...recording.attributes.map(({ name, values }) => ({ name, value: (row: number) => values[row] })),
  ];
}

export function cellTable(recording: Recording, frame: number): HTMLTableElement {
  const columns = columnsOf(recording);
  const head = h('tr', {}, ...columns.map(({ name }) => h('th', { scope: 'col' }, name)));
  const body = h('tbody');
  for (let row = recording.rowStart[frame]; row < recording.rowStart[frame + 1]; ++row)
    body.append(
      h(
        'tr',
        {},
        ...columns.map(({ value }) => {
          const content = value(row);
          return typeof content === 'number'
            ? h('td', { 'data-value': String(content) }, number(content))
            : h('td', { 'data-value': content }, content);
        }),
      ),
    );
  return h('table', {}, h('thead', {}, head), body);
}

export function cellCsv(recording: Recording, frame: number): string {
  const columns = columnsOf(recording);
  const lines = [columns.map(({ name }) => name).join(',')];
  for (let row = recording.rowStart[frame]; row < recording.rowStart[frame + 1]; ++row)
    lines.push(columns.map(({ value }) => String(value(row))).join(','));
  return lines.join('\n') + '\n';
}
