// What the page says of the cells at a step, what a recording holds, and where the two differ.
import { execFileSync } from 'node:child_process';
import { fileURLToPath } from 'node:url';
import type { Page } from 'playwright-core';

import { press, seek } from './support';

type Value = string | number | null;
/** Cells of a step by column; null: not a number. */
export type Columns = Record<string, Value[]>;

/** A step of a recording, as web/browser/recorded_cells.py reads it. */
export interface RecordedStep {
  step: number;
  columns: Columns;
  population: Record<string, number>;
  deaths: Record<string, number>;
}

const script = fileURLToPath(new URL('recorded_cells.py', import.meta.url));
const python = (...words: string[]): string =>
  execFileSync('/usr/bin/python3', [script, ...words], { encoding: 'utf8', maxBuffer: 1 << 28 });

export const readRecording = (file: string, steps: number[]): RecordedStep[] =>
  JSON.parse(python(file, 'read', ...steps.map(String))) as RecordedStep[];

/** Changes one value of one cell by as little as its type allows. */
export function alterCell(file: string, step: number, organism: number, cell: number, column: string): void {
  python(file, 'alter', ...[step, organism, cell, column].map(String));
}

const valueOf = (text: string): Value => (text === 'NaN' ? null : text === '' || Number.isNaN(Number(text)) ? text : Number(text));

/** The table of all cells at a step. */
export async function shownCells(page: Page, step: number): Promise<Columns> {
  await seek(page, step);
  await page.click('#open-table');
  const [names, rows] = await page.evaluate(() => {
    const all = (selector: string, of: ParentNode) => [...of.querySelectorAll<HTMLElement>(selector)];
    return [
      all('#table-rows th', document).map((head) => head.textContent),
      all('#table-rows tbody tr', document).map((row) => all('td', row).map((cell) => cell.dataset.value ?? '')),
    ];
  });
  await press(page, 'Escape');
  return Object.fromEntries(names.map((name, column) => [name, rows.map((row) => valueOf(row[column]))]));
}

/** One line per value that is not the same; nothing of the page may be missing in the recording. */
export function differences(step: number, shown: Columns, recorded: Columns): string[] {
  const found: string[] = [];
  for (const [name, values] of Object.entries(shown)) {
    const others = recorded[name] as Value[] | undefined;
    if (others?.length !== values.length) {
      found.push(`step ${step}: ${name} of ${values.length} cells on the page, of ${others?.length ?? 'no'} recorded`);
      continue;
    }
    values.forEach((value, i) => {
      if (value !== others[i])
        found.push(
          `step ${step}, cell ${String(shown.cell[i])}: ${name} is ${String(value)} on the page, ${String(others[i])} recorded`,
        );
    });
  }
  return found;
}
