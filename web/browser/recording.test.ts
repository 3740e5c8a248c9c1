// The page against the recording of the same life: every value of every cell at random steps.
import { copyFileSync } from 'node:fs';
import type { Browser, Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';

import { Chance } from './chance';
import { alterCell, differences, readRecording, shownCells, type Columns, type RecordedStep } from './shown_cells';
import { drawn, launch, open, seek, Workshop, type Opened } from './support';

const workshop = new Workshop();
const chance = new Chance('steps, cells and columns');
let browser: Browser;
let opened: Opened;
let page: Page;
let steps: number[];
let recorded: RecordedStep[];
const shown: Columns[] = [];

beforeAll(async () => {
  workshop.run('exp1.yaml', 'run', '--set', 'evolution.population=30', '--generations', '3', '--seed', '3');
  workshop.host('replay', 'run', '--html', 'life.html', '--record', 'life.h5', '--every', '1');
  browser = await launch();
  opened = await open(browser, workshop.path('life.html'));
  page = opened.page;
  // Nobody lives at the last step.
  steps = chance.several(3, Number(await page.getAttribute('#step', 'max')));
  recorded = readRecording(workshop.path('life.h5'), steps);
  for (const step of steps) shown.push(await shownCells(page, step));
});
afterAll(async () => {
  expect(opened.complaints).toEqual([]);
  await browser.close();
  workshop.remove();
});

/** Where the page differs from a recording, at all three steps. */
const compare = (file: string, cells: Columns[] = shown): string[] =>
  readRecording(workshop.path(file), steps).flatMap(({ step, columns }, s) => differences(step, cells[s], columns));

describe('the page of a life', () => {
  it('shows every value of every cell as the recording has it', () => {
    for (const { columns, step } of recorded) expect(columns.cell.length, `step ${step}`).toBeGreaterThan(0);
    // Whatever the recording knows of a cell is there, but for inputs that are columns themselves.
    const doubled = ['sensed pressure', 'sensed energy', 'sensed ambrosia'];
    expect(Object.keys(shown[0])).toEqual(Object.keys(recorded[0].columns).filter((name) => !doubled.includes(name)));
    expect(compare('life.h5')).toEqual([]);
  });

  it('counts cells and deaths as the recording does', async () => {
    for (const { step, population, deaths } of recorded) {
      await seek(page, step);
      const counts = Object.entries(population).map(([state, count]) => `${count} ${state}`).join(', ');
      expect(await page.textContent('.counts')).toContain(counts);
      for (const [state, count] of Object.entries(population))
        expect(await page.textContent(`[aria-label="Cells by state"] [data-series="${state}"]`)).toBe(String(count));
      const chart = page.locator('[aria-label="Deaths so far, by cause"]');
      for (const [cause, count] of Object.entries(deaths))
        expect(await chart.locator(`[data-series="${cause.replaceAll('_', ' ')}"]`).textContent()).toBe(String(count));
    }
  });

  it('tells of a selected cell what the recording has', async () => {
    for (const { step, columns } of recorded) {
      const row = chance.below(columns.cell.length);
      const [organism, cell] = [columns.organism[row], columns.cell[row]].map(String);
      await page.evaluate((hash) => { location.hash = hash; }, `#step=${step}&cell=0,${organism},${cell}`);
      await page.waitForSelector(`#cell h3:has-text("Cell ${cell} ")`);
      await drawn(page);
      const fields = await page.locator('#cell [data-field][data-value]').evaluateAll((all) =>
        all.map((each) => [(each as HTMLElement).dataset.field!, (each as HTMLElement).dataset.value!]),
      );
      expect(fields.map(([name]) => name)).toEqual(
        expect.arrayContaining(['x', 'y', 'energy', 'pressure', 'ambrosia', 'sensed morphogen.0', 'output division']),
      );
      for (const [name, value] of fields) {
        const born = Number(columns.born[row]);
        const expected = name === 'age' ? step - born : (columns[name][row] ?? 'NaN');
        expect(value, `${name} of cell ${cell} at step ${step}`).toBe(String(expected));
      }
      expect(await page.textContent('#cell [data-field=state]')).toBe(columns.state[row]);
    }
  });
});

describe('a recording altered in one cell', () => {
  const alter = (file: string): { step: number; cell: number; column: string } => {
    copyFileSync(workshop.path('life.h5'), workshop.path(file));
    const { step, columns } = chance.of(recorded);
    const row = chance.below(columns.cell.length);
    const column = chance.of(Object.keys(shown[0]).filter((name) => name !== 'organism' && name !== 'cell'));
    const [organism, cell] = [Number(columns.organism[row]), Number(columns.cell[row])];
    alterCell(workshop.path(file), step, organism, cell, column);
    return { step, cell, column };
  };

  it('is not what the page shows', () => {
    for (let i = 0; i < 3; ++i) {
      const { step, cell, column } = alter('altered.h5');
      const found = compare('altered.h5');
      expect(found).toHaveLength(1);
      expect(found[0]).toContain(`step ${step}, cell ${cell}: ${column} is `);
    }
  });

  it('makes a page that shows the altered cell, and no other', async () => {
    const { step, cell, column } = alter('altered.h5');
    workshop.host('replay', 'altered.h5', '--html', 'altered.html');
    const other = await open(browser, workshop.path('altered.html'));
    const cells: Columns[] = [];
    for (const each of steps) cells.push(await shownCells(other.page, each));
    expect(compare('altered.h5', cells)).toEqual([]);
    const found = compare('life.h5', cells);
    expect(found).toHaveLength(1);
    expect(found[0]).toContain(`step ${step}, cell ${cell}: ${column} is `);
    expect(other.complaints).toEqual([]);
    await other.close();
  });
});
