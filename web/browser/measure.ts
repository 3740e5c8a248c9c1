// How fast replay pages are in Chromium: size, time to load, frames a second while playing.
//
// usage: npm run --silent measure -- PAGE.html...
//
// Plays where the most cells live, at 120 steps a second, so that every frame of the screen (at
// most 60 a second) shows another step; for five seconds. Prints a line a page. The time that the
// page's main thread works for a frame says what an idle machine would do.
import { statSync } from 'node:fs';
import { resolve } from 'node:path';
import type { CDPSession, Page } from 'playwright-core';

import { launch, open, seek } from './support';

const seconds = 5;

const cellsOf = async (page: Page): Promise<number> =>
  Number(/: ([\d,]+) cell/.exec((await page.locator('.counts').first().textContent())!)![1].replaceAll(',', ''));

/** The step with the most cells, looked for at 60 places. */
async function busiest(page: Page): Promise<{ step: number; cells: number }> {
  const [first, last] = await Promise.all(['min', 'max'].map(async (end) => Number(await page.getAttribute('#step', end))));
  let best = { step: first, cells: 0 };
  for (let i = 0; i < 60; ++i) {
    const step = Math.round(first + ((last - first) * i) / 60);
    await seek(page, step);
    const cells = await cellsOf(page);
    if (cells > best.cells) best = { step, cells };
  }
  return best;
}

/** Milliseconds from frame to frame of the screen while the page plays, ascending. */
async function play(page: Page, from: number): Promise<number[]> {
  await page.selectOption('#speed', '120');
  const times: number[] = [];
  for (const end = Date.now() + 1000 * seconds; Date.now() < end; ) {
    await seek(page, from);
    await page.click('#play');
    times.push(
      ...(await page.evaluate(
        (most) =>
          new Promise<number[]>((done) => {
            const intervals: number[] = [];
            const begin = performance.now();
            let before = begin;
            const next = (now: number) => {
              intervals.push(now - before);
              before = now;
              const playing = document.getElementById('play')!.getAttribute('aria-label') === 'Pause';
              if (playing && now - begin < most) requestAnimationFrame(next);
              else done(intervals.slice(2));
            };
            requestAnimationFrame(next);
          }),
        Math.max(end - Date.now(), 100),
      )),
    );
    if ((await page.getAttribute('#play', 'aria-label')) === 'Pause') await page.click('#play');
  }
  return times.sort((a, b) => a - b);
}

/** Seconds of processor time of the page's main thread so far. */
async function worked(session: CDPSession): Promise<number> {
  const { metrics } = await session.send('Performance.getMetrics');
  return metrics.find(({ name }) => name === 'TaskDuration')!.value;
}

const browser = await launch();
for (const file of process.argv.slice(2)) {
  const before = performance.now();
  const { page, close } = await open(browser, resolve(file));
  const load = performance.now() - before;
  const { step, cells } = await busiest(page);
  const session = await page.context().newCDPSession(page);
  await session.send('Performance.enable', { timeDomain: 'threadTicks' });
  const idle = await worked(session);
  const times = await play(page, step);
  const work = (await worked(session)) - idle;
  const left = await cellsOf(page);
  const rate = (1000 * times.length) / times.reduce((sum, time) => sum + time, 0);
  const slow = times[Math.floor(times.length * 0.95)];
  process.stdout.write(
    `${file}: ${(statSync(file).size / 1e6).toFixed(1)} MB, shown after ${(load / 1000).toFixed(2)} s; from step ${step}, ` +
      `${cells} to ${left} cells: ${rate.toFixed(1)} frames/s, 95 % of them within ${slow.toFixed(0)} ms, ` +
      `${((1000 * work) / times.length).toFixed(1)} ms of work each\n`,
  );
  await close();
}
await browser.close();
