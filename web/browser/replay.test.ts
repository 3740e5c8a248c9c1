// The replay page of a real run, opened from the disk in Chromium.
import { readFileSync } from 'node:fs';
import axe from 'axe-core';
import type { Browser, Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, it } from 'vitest';

import { Chance } from './chance';
import { drawn, launch, open, pixels, press, seek, shoot, stepOf, Workshop, type Look, type Opened } from './support';

const workshop = new Workshop();
const chance = new Chance('steps with counts');
const nutritive = '#E69F00';
let browser: Browser;

beforeAll(async () => {
  workshop.run('exp1.yaml', 'run', '--set', 'evolution.population=30', '--generations', '4', '--seed', '7');
  workshop.host('replay', 'run', '--html', 'life.html', '--csv', 'life.csv');
  workshop.host(
    'replay', 'run', '--html', 'two.html', '--compare-set', 'environments.particle_aggression.rate_scale=0',
    '--compare-set', 'world.max_steps=400',
  );
  browser = await launch();
});
afterAll(async () => {
  await browser.close();
  workshop.remove();
});

interface Census {
  step: number;
  cells: Record<string, number>;
}
function census(file: string): Census[] {
  const [head, ...lines] = readFileSync(workshop.path(file), 'utf8').trim().split('\n');
  const names = head.split(',').slice(1, -2);
  return lines.map((line) => {
    const [step, ...values] = line.split(',');
    return { step: Number(step), cells: Object.fromEntries(names.map((name, i) => [name, Number(values[i])])) };
  });
}

async function violations(page: Page): Promise<string[]> {
  await page.evaluate(axe.source);
  const { violations: found } = await page.evaluate(() =>
    (window as unknown as { axe: typeof axe }).axe.run(document, {
      runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'best-practice'],
    }),
  );
  return found.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html).join(' ')}`);
}

describe('the page of one life', () => {
  let opened: Opened;
  let page: Page;
  const show = async (look: Look = {}) => {
    opened = await open(browser, workshop.path('life.html'), look);
    page = opened.page;
  };
  beforeEach(() => show());
  // Whatever a test does, the page stays silent and at home.
  afterEach(async () => {
    expect(opened.complaints).toEqual([]);
    await opened.close();
  });

  it('draws the cells of the first step', async () => {
    expect(await stepOf(page)).toBe(0);
    expect(await page.textContent('.counts')).toContain('1 cell, 1 nutritive, 0 defensive');
    expect(await pixels(page, nutritive)).toBeGreaterThan(50);
  });

  it('plays, pauses and stops at the end', async () => {
    await page.selectOption('#speed', '60');
    await page.click('#play');
    await page.waitForFunction(() => Number((document.getElementById('step') as HTMLInputElement).value) > 20);
    await press(page, 'Escape');
    await page.click('#play');
    const paused = await stepOf(page);
    await page.waitForTimeout(300);
    expect(await stepOf(page)).toBe(paused);
    await press(page, 'End');
    const last = census('life.csv').at(-1)!.step;
    expect(await stepOf(page)).toBe(last);
    await press(page, 'ArrowRight');
    expect(await stepOf(page)).toBe(last);
  });

  it('steps and scrubs by mouse and keyboard', async () => {
    await page.click('#forward');
    await page.click('#forward');
    await page.click('#back');
    expect(await stepOf(page)).toBe(1);
    await page.locator('h1').click();
    await press(page, 'Shift+ArrowRight');
    expect(await stepOf(page)).toBe(11);
    const box = (await page.locator('#scrub').boundingBox())!;
    await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
    const last = census('life.csv').at(-1)!.step;
    expect(Math.abs((await stepOf(page)) - last / 2)).toBeLessThan(last * 0.03);
  });

  it('shows at any step the numbers of cells that the replay counted', async () => {
    const steps = census('life.csv');
    for (const { step, cells } of chance.several(3, steps.length).map((i) => steps[i])) {
      await seek(page, step);
      const expected = Object.entries(cells).map(([name, count]) => `${count} ${name}`).join(', ');
      const total = Object.values(cells).reduce((sum, count) => sum + count, 0);
      expect(await page.textContent('.counts'), `step ${step}`).toContain(total === 0 ? '0 cells' : expected);
      for (const [name, count] of Object.entries(cells))
        expect(await page.textContent(`[aria-label="Cells by state"] [data-series="${name}"]`)).toBe(String(count));
    }
  });

  it('selects the cell under the mouse and tells its life and family', async () => {
    await seek(page, 150);
    const canvas = (await page.locator('.stage canvas').boundingBox())!;
    // The middle of an organism need not be a cell: try outwards from it.
    for (let r = 0; r < 120 && (await page.locator('#cell h3').count()) === 0; r += 12) {
      await page.mouse.click(canvas.x + canvas.width / 2 + r, canvas.y + canvas.height / 2);
      await drawn(page);
    }
    expect(await page.textContent('#cell h3')).toMatch(/^Cell \d+ (nutritive|defensive)$/);
    expect(Number(await page.getAttribute('[data-field="energy"]', 'data-value'))).toBeGreaterThan(0);
    expect(await page.locator('.bars dt').allTextContents()).toContain('division');
    expect(await page.locator('canvas.life').count()).toBe(1);
    await shoot(page, 'selected');
    await press(page, 'Escape');
    expect(await page.locator('#cell h3').count()).toBe(0);
  });

  it('walks the family by keyboard and buttons', async () => {
    await seek(page, 120);
    await page.locator('h1').click();
    await press(page, 'p'); // the youngest
    const young = await page.textContent('#cell h3');
    const mother = await page.textContent('.family p:first-of-type .chip');
    await press(page, 'm');
    expect(await page.textContent('#cell h3')).toContain(`Cell ${mother!.replace(' †', '')}`);
    const id = /Cell (\d+)/.exec(young!)![1];
    await page.locator('.family p:last-of-type .chip', { hasText: new RegExp(`^${id}$`) }).click();
    await drawn(page);
    expect(await page.textContent('#cell h3')).toBe(young);
    await page.check('#family');
    await shoot(page, 'descendants');
  });

  it('colours cells by everything that it lists', async () => {
    await seek(page, 150);
    const names = await page.locator('#colour option').evaluateAll((all) =>
      all.map((each) => (each as HTMLOptionElement).value),
    );
    expect(names).toEqual(expect.arrayContaining([
      'state', 'clone', 'energy', 'ambrosia', 'pressure', 'damage particle_aggression', 'sensed morphogen.0',
      'sensed morphogen.2', 'output division',
    ]));
    const pictures = new Set<string>();
    for (const name of ['state', 'clone', 'energy', 'ambrosia', 'pressure', 'sensed morphogen.0']) {
      await page.selectOption('#colour', name);
      await drawn(page);
      pictures.add(await page.evaluate(() => document.querySelector<HTMLCanvasElement>('.stage canvas')!.toDataURL()));
    }
    expect(pictures.size).toBe(6);
    await shoot(page, 'morphogen');
  });

  it('turns layers on and off, those that environments declared too', async () => {
    await seek(page, 200);
    const names = await page.locator('[data-layer]').evaluateAll((all) =>
      all.map((each) => (each as HTMLInputElement).dataset.layer),
    );
    expect(names).toEqual(expect.arrayContaining([
      'cells', 'actions', 'contacts', 'deaths', 'table:particle_aggression.particles', 'grid:nutrients.content',
      'grid:morphogen.0',
    ]));
    const particle = '#D55E00';
    expect(await pixels(page, particle)).toBeGreaterThan(20);
    await page.uncheck('[data-layer="table:particle_aggression.particles"]');
    await drawn(page);
    expect(await pixels(page, particle)).toBeLessThan(5);
    await page.uncheck('[data-layer="cells"]');
    await drawn(page);
    expect(await pixels(page, nutritive)).toBe(0);
    await page.check('[data-layer="grid:morphogen.0"]');
    await page.check('[data-layer="contacts"]');
    await page.check('[data-layer="cells"]');
    await shoot(page, 'layers');
  });

  it('pans, zooms and shows everything again', async () => {
    await seek(page, 150);
    const bar = () => page.evaluate(() => location.hash);
    const canvas = (await page.locator('.stage canvas').boundingBox())!;
    await page.mouse.move(canvas.x + canvas.width / 2, canvas.y + canvas.height / 2);
    const before = await pixels(page, nutritive);
    await page.mouse.wheel(0, -600);
    await page.waitForTimeout(400);
    const closer = await pixels(page, nutritive);
    expect(closer).toBeGreaterThan(before * 1.5);
    const link = await bar();
    await page.mouse.down();
    await page.mouse.move(canvas.x + canvas.width / 2 + 90, canvas.y + canvas.height / 2 + 40, { steps: 4 });
    await page.mouse.up();
    await page.waitForTimeout(400);
    expect(await bar()).not.toBe(link);
    await page.locator('h1').click();
    await press(page, '0');
    await drawn(page);
    expect(Math.abs((await pixels(page, nutritive)) - before)).toBeLessThan(before * 0.02);
  });

  it('draws cells round when a stage gets less room', async () => {
    await page.evaluate(() => { document.querySelector<HTMLElement>('.stage canvas')!.style.height = '300px'; });
    await drawn(page);
    const [across, up, height] = await page.evaluate(() => {
      const canvas = document.querySelector<HTMLCanvasElement>('.stage canvas')!;
      return [canvas.width / canvas.clientWidth, canvas.height / canvas.clientHeight, canvas.clientHeight];
    });
    expect(height).toBe(300);
    expect(across).toBeCloseTo(up, 2);
  });

  it('is found again by its link', async () => {
    await seek(page, 140);
    await page.selectOption('#colour', 'pressure');
    await page.uncheck('[data-layer="deaths"]');
    await page.locator('h1').click();
    await press(page, 'n');
    await page.waitForTimeout(450);
    const hash = await page.evaluate(() => location.hash);
    expect(hash).toContain('step=140&cell=0,0,');
    const cell = await page.textContent('#cell h3');
    await opened.close();
    await show({ hash });
    expect(await stepOf(page)).toBe(140);
    expect(await page.inputValue('#colour')).toBe('pressure');
    expect(await page.isChecked('[data-layer="deaths"]')).toBe(false);
    expect(await page.textContent('#cell h3')).toBe(cell);
  });

  it('goes where a chart is clicked, in all charts', async () => {
    const over = (await page.locator('.u-over').nth(2).boundingBox())!;
    await page.mouse.click(over.x + over.width * 0.5, over.y + over.height / 2);
    const step = await stepOf(page);
    expect(step).toBeGreaterThan(0);
    const places = await page.locator('.playhead').evaluateAll((all) =>
      all.map((each) => new DOMMatrix(getComputedStyle(each).transform).e / each.parentElement!.clientWidth),
    );
    expect(places).toHaveLength(3);
    for (const place of places) expect(place).toBeCloseTo(places[0], 2);
  });

  it('saves a picture', async () => {
    await seek(page, 150);
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('#export')]);
    expect(download.suggestedFilename()).toBe('somas-step-00150.png');
    const bytes = readFileSync(await download.path());
    expect(bytes.subarray(1, 4).toString()).toBe('PNG');
    expect(bytes.readUInt32BE(16)).toBeGreaterThan(1000); // its width
    expect(bytes.length).toBeGreaterThan(20_000);
  });

  it('lists the cells of the step, for readers and as CSV', async () => {
    await seek(page, 100);
    await page.click('#open-table');
    const { cells } = census('life.csv')[100];
    const total = Object.values(cells).reduce((sum, count) => sum + count, 0);
    expect(await page.locator('#table-rows tbody tr').count()).toBe(total);
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('#table-csv')]);
    const lines = readFileSync(await download.path(), 'utf8').trim().split('\n');
    expect(lines).toHaveLength(total + 1);
    expect(await violations(page)).toEqual([]);
  });

  it('explains its keys and lets them be turned off', async () => {
    await page.locator('h1').click();
    await press(page, '?');
    expect(await page.isVisible('#help')).toBe(true);
    await shoot(page, 'help');
    expect(await violations(page)).toEqual([]);
    await page.uncheck('#keys-on');
    await press(page, 'Escape');
    await page.locator('h1').click();
    await press(page, 'End');
    expect(await stepOf(page)).toBe(0);
  });

  for (const scheme of ['light', 'dark'] as const)
    it(`is accessible and legible, ${scheme}`, async () => {
      await opened.close();
      await show({ scheme, hash: '#step=150&cell=0,0,0' });
      expect(await violations(page)).toEqual([]);
      await shoot(page, scheme);
      await page.click('#theme');
      expect(await violations(page)).toEqual([]);
    });

  it('fits a telephone', async () => {
    await opened.close();
    await show({ width: 390, height: 844, hash: '#step=150' });
    const overflow = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
    expect(overflow).toBeLessThanOrEqual(0);
    expect(await violations(page)).toEqual([]);
    await shoot(page, 'telephone');
  });
});

describe('the page of two lives', () => {
  it('shows both at the same step, one of them after its end', async () => {
    const { page, complaints, close } = await open(browser, workshop.path('two.html'));
    expect(await page.locator('.view').count()).toBe(2);
    const last = census('life.csv').at(-1)!.step;
    const common = Math.min(last, 399) - 20;
    await seek(page, common);
    const captions = await page.locator('.counts').allTextContents();
    expect(captions[0]).toContain(`step ${common}:`);
    expect(captions[1]).toContain(`step ${common}:`);
    expect(captions[0]).not.toBe(captions[1]);
    expect(await page.textContent('.view:nth-child(2) figcaption')).toContain('rate_scale=0');
    // Particles are in the first world only.
    expect(await pixels(page, '#D55E00', 0)).toBeGreaterThan(20);
    expect(await pixels(page, '#D55E00', 1)).toBeLessThan(5);
    await press(page, 'End');
    await page.locator('h1').click();
    await press(page, 'End');
    await page.waitForTimeout(100);
    expect((await page.locator('.counts').allTextContents()).join()).toContain('the life has ended');
    await seek(page, common);
    await page.locator('h1').click();
    const canvas = (await page.locator('.stage canvas').nth(1).boundingBox())!;
    await page.mouse.click(canvas.x + canvas.width / 2, canvas.y + canvas.height / 2);
    expect(await violations(page)).toEqual([]);
    await shoot(page, 'two-lives');
    expect(complaints).toEqual([]);
    await close();
  });
});

describe('the page of organisms in company', () => {
  it('outlines each in a colour of its own, as long as that layer is on', async () => {
    workshop.run('competition.yaml', 'company', '--set', 'evolution.population=8', '--generations', '2');
    workshop.host('replay', 'company', '--html', 'company.html');
    const { page, complaints, close } = await open(browser, workshop.path('company.html'));
    const colours = ['#00504a', '#c0268b'];
    for (const colour of colours) expect(await pixels(page, colour)).toBeGreaterThan(20);
    expect(await page.locator('#layers').textContent()).toMatch(/outline of organism [12] \(this champion\)/);
    await shoot(page, 'company');
    await page.uncheck('[data-layer="organism:1"]');
    expect(await pixels(page, colours[0])).toBeGreaterThan(20);
    expect(await pixels(page, colours[1])).toBeLessThan(5);
    await page.selectOption('#colour', 'organism');
    expect(await pixels(page, colours[1])).toBeGreaterThan(50);
    expect(await violations(page)).toEqual([]);
    expect(complaints).toEqual([]);
    await close();
  });
});

describe('a page that cannot be shown', () => {
  it('says why', async () => {
    const { mkdtempSync, writeFileSync } = await import('node:fs');
    const file = `${mkdtempSync(workshop.path('bad-'))}/bad.html`;
    const good = readFileSync(workshop.path('life.html'), 'utf8');
    const start = good.indexOf('recording">') + 11;
    writeFileSync(file, good.slice(0, start) + good.slice(start, start + 4000) + good.slice(good.indexOf('</script>', start)));
    const context = await browser.newContext();
    const page = await context.newPage();
    await page.goto(`file://${file}`);
    await page.waitForSelector('[role=alert]');
    expect(await page.textContent('[role=alert]')).toContain('This replay cannot be shown');
    await context.close();
  });
});
