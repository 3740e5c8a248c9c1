// A life of three frames that a person can follow.
//
// Step 0: the founder 0. Step 1: 0 and its daughter 1. Step 2: 1 and its daughter 2, after 0 starved.
import { decodePack } from '../src/pack';
import { Recording } from '../src/recording';
import { encodePack, type Block } from './encode';

export const previous = [-1, 0, -1, 2, -1];

export function lifeBlocks(): Block[] {
  const cells = (name: string, type: Block['type'], values: number[]): Block => ({
    name: `cell.${name}`,
    type,
    values,
    encoding: 'cell',
  });
  return [
    { name: 'frame.step', type: 'u32', values: [10, 11, 12], encoding: 'delta' },
    { name: 'frame.rows', type: 'u32', values: [0, 1, 3, 5], encoding: 'delta' },
    { name: 'frame.fields', type: 'u32', values: [0, 1, 1] },
    { name: 'cell.organism', type: 'u16', values: [0, 0, 0, 0, 0], encoding: 'delta' },
    { name: 'cell.id', type: 'u32', values: [0, 0, 1, 1, 2], encoding: 'delta' },
    cells('parent', 'u32', [0, 0, 0, 0, 1]),
    cells('born', 'u32', [10, 10, 11, 11, 12]),
    cells('state', 'u16', [0, 0, 1, 1, 0]),
    cells('action', 'u8', [0, 2, 1, 1, 0]),
    cells('x', 'f32', [0, 0.5, 1.5, 1.625, -1.25]),
    cells('y', 'f32', [0, 0, 0, 0, 0]),
    cells('radius', 'f32', [1, 1, 1, 1, 1]),
    cells('energy', 'f32', [1, 0.5, 0.25, 0.125, NaN]),
    { name: 'table.0.rows', type: 'u32', values: [0, 0, 2, 2], encoding: 'delta' },
    { name: 'table.0.x', type: 'f32', values: [7, 8] },
    { name: 'table.0.y', type: 'f32', values: [-7, -8] },
    { name: 'event.step', type: 'u32', values: [11, 12, 12], encoding: 'delta' },
    { name: 'event.kind', type: 'u8', values: [0, 0, 1] },
    { name: 'event.organism', type: 'u16', values: [0, 0, 0] },
    { name: 'event.cell', type: 'u32', values: [1, 2, 0] },
    { name: 'event.parent', type: 'u32', values: [0, 1, 0] },
    { name: 'event.state', type: 'u16', values: [0, 0, 0] },
    { name: 'event.cause', type: 'u16', values: [0xffff, 0xffff, 0] },
    { name: 'event.x', type: 'f32', values: [1, 2, 3] },
    { name: 'event.y', type: 'f32', values: [0, 0, 0] },
    { name: 'summary.step', type: 'u32', values: [10, 11, 12], encoding: 'delta' },
    { name: 'summary.population.0.0', type: 'u32', values: [1, 1, 1], encoding: 'delta' },
    { name: 'summary.population.0.1', type: 'u32', values: [0, 1, 1], encoding: 'delta' },
    { name: 'summary.energy.0', type: 'f32', values: [1, 0.375, 0.125] },
    { name: 'summary.ambrosia.0', type: 'f32', values: [0, 0, 0] },
    { name: 'summary.grid.0', type: 'f32', values: [4, 3, 2] },
    { name: 'grid.0', type: 'u8', values: [0, 255, 10, 3], encoding: 'delta', stride: 4 },
  ];
}

export const lifeHeader = {
  title: 'tiny',
  subtitle: 'by hand',
  changes: [],
  radius: 10,
  max_steps: 100,
  every: 1,
  own: 0,
  survival: 12,
  censored: false,
  organisms: [
    {
      states: [
        { name: 'root', parent: null },
        { name: 'leaf', parent: 0 },
      ],
      outputs: [],
    },
  ],
  actions: ['none', 'quiescence', 'division', 'specialization', 'apoptosis'],
  causes: ['starvation'],
  tables: ['rain.drops'],
  grids: [
    { name: 'food.content', columns: 2, rows: 2, side: 1, left: 0, bottom: 0, low: 0, high: 2, resource: 'food' },
  ],
  outlines: [],
  attributes: [{ name: 'energy', group: 'cell', column: 'cell.energy' }],
};

export const tinyLife = (): Recording =>
  new Recording(decodePack(encodePack(lifeHeader, lifeBlocks(), previous)));
