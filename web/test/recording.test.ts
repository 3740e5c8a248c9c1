import { describe, expect, it } from 'vitest';

import { rangeOf } from '../src/recording';
import { tinyLife } from './life';

const cell = (id: number) => ({ organism: 0, id });

describe('a recording', () => {
  const life = tinyLife();

  it('finds the frame that holds at a step', () => {
    expect([0, 10, 11, 12, 99].map((step) => life.frameAt(step))).toEqual([0, 0, 1, 2, 2]);
  });

  it('finds cells by name, and none that does not live', () => {
    expect(life.rowOf(1, cell(1))).toBe(2);
    expect(life.rowOf(0, cell(1))).toBe(-1);
    expect(life.rowOf(2, cell(0))).toBe(-1);
    expect(life.rowOf(1, { organism: 1, id: 0 })).toBe(-1);
  });

  it('tells the life of a cell', () => {
    expect(life.lifeOf(cell(1))).toEqual([
      { frame: 1, row: 2 },
      { frame: 2, row: 3 },
    ]);
    expect(life.lifeOf(cell(7))).toEqual([]);
  });

  it('knows mother, daughters, birth and death', () => {
    expect(life.motherOf(cell(2))).toEqual(cell(1));
    expect(life.motherOf(cell(0))).toBeUndefined();
    expect(life.daughtersOf(cell(0))).toEqual([{ ...cell(1), born: 11 }]);
    expect(life.daughtersOf(cell(2))).toEqual([]);
    expect(life.birthStep(cell(2))).toBe(12);
    expect(life.death(cell(0))).toEqual({ step: 12, cause: 'starvation' });
    expect(life.death(cell(1))).toBeUndefined();
  });

  it('knows descent', () => {
    expect(life.isDescendant(cell(2), cell(0))).toBe(true);
    expect(life.isDescendant(cell(1), cell(1))).toBe(true);
    expect(life.isDescendant(cell(0), cell(1))).toBe(false);
    expect(life.ancestorAt(cell(2), 11)).toEqual(cell(1));
    expect(life.ancestorAt(cell(2), 10)).toEqual(cell(0));
    expect(life.ancestorAt(cell(2), 12)).toEqual(cell(2));
  });

  it('sums population by name of the state and counts deaths so far', () => {
    expect(life.timeline.step).toEqual([10, 11, 12]);
    expect([...life.timeline.population]).toEqual([
      ['root', [1, 1, 1]],
      ['leaf', [0, 1, 1]],
    ]);
    expect([...life.timeline.deaths]).toEqual([['starvation', [0, 0, 1]]]);
    expect([...life.timeline.resources]).toEqual([['food', [4, 3, 2]]]);
  });

  it('hands out tables and grids of a frame', () => {
    expect([...life.table(0, 1).x]).toEqual([7, 8]);
    expect([...life.table(0, 1).y]).toEqual([-7, -8]);
    expect(life.table(0, 2).x).toHaveLength(0);
    expect(life.fieldFrame(0)).toBe(-1);
    expect([...life.grid(0, life.fieldFrame(2))]).toEqual([0, 255, 10, 3]);
  });

  it('measures ranges past what is no number', () => {
    expect(life.attribute('energy')).toMatchObject({ low: 0.125, high: 1 });
    expect(rangeOf(new Float32Array([NaN]))).toEqual({ low: 0, high: 1 });
  });
});
