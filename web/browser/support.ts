// A real run, its replay pages, and a browser that opens them from the disk.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { chromium, type Browser, type Page } from 'playwright-core';

const need = (name: string): string => {
  const value = process.env[name];
  if (value === undefined) throw new Error(`${name} is not set: tests/web/run.sh sets it`);
  return value;
};

export const screenshots = (): string => need('SOMAS_SCREENSHOTS');

/** A scratch directory that holds runs and pages. */
export class Workshop {
  readonly directory = mkdtempSync(join(tmpdir(), 'somas-web-'));

  host(...args: string[]): string {
    return execFileSync(need('SOMAS_HOST'), args, {
      cwd: this.directory,
      encoding: 'utf8',
      stdio: ['ignore', 'pipe', 'pipe'],
      maxBuffer: 1 << 26,
    });
  }
  run(experiment: string, out: string, ...args: string[]): void {
    this.host(join(need('SOMAS_EXPERIMENTS'), experiment), '--out', out, '-q', ...args);
  }
  path(name: string): string {
    return join(this.directory, name);
  }
  remove(): void {
    rmSync(this.directory, { recursive: true, force: true });
  }
}

export const launch = (): Promise<Browser> =>
  chromium.launch({
    executablePath: '/usr/bin/chromium',
    args: [
      '--no-sandbox',
      '--disable-gpu',
      '--disable-quic',
      '--no-first-run',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
    ],
  });

/** An open page that notes whatever it should not do. */
export interface Opened {
  page: Page;
  complaints: string[];
  close: () => Promise<void>;
}

export interface Look {
  width?: number;
  height?: number;
  scheme?: 'light' | 'dark';
  hash?: string;
}

export async function open(browser: Browser, file: string, look: Look = {}): Promise<Opened> {
  const context = await browser.newContext({
    viewport: { width: look.width ?? 1440, height: look.height ?? 900 },
    colorScheme: look.scheme ?? 'light',
    reducedMotion: 'reduce',
    acceptDownloads: true,
  });
  const page = await context.newPage();
  const complaints: string[] = [];
  const url = pathToFileURL(file).href;
  page.on('console', (message) => complaints.push(`console ${message.type()}: ${message.text()}`));
  page.on('pageerror', (error) => complaints.push(`error: ${error.message}`));
  page.on('request', (request) => {
    const to = request.url();
    if (to.split('#')[0] !== url && !to.startsWith('data:') && !to.startsWith('blob:'))
      complaints.push(`request: ${to}`);
  });
  await page.goto(url + (look.hash ?? ''));
  await page.waitForSelector('#app[aria-busy=false]');
  return { page, complaints, close: () => context.close() };
}


/** Until what was asked for is drawn. */
export async function drawn(page: Page): Promise<void> {
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

/** The step that the page shows. */
export async function stepOf(page: Page): Promise<number> {
  await drawn(page);
  return Number(await page.inputValue('#step'));
}

export async function press(page: Page, key: string): Promise<void> {
  await page.keyboard.press(key);
  await drawn(page);
}

export async function seek(page: Page, step: number): Promise<void> {
  await page.fill('#step', String(step));
  await page.press('#step', 'Enter');
  await drawn(page);
}

export async function shoot(page: Page, name: string): Promise<void> {
  await page.screenshot({ path: join(screenshots(), `${name}.png`), fullPage: true });
}

/** How many pixels of a stage have nearly this colour. */
export async function pixels(page: Page, hex: string, view = 0): Promise<number> {
  await drawn(page);
  return page.evaluate(
    ([colour, index]) => {
      const canvas = document.querySelectorAll<HTMLCanvasElement>('.stage canvas')[Number(index)];
      const copy = document.createElement('canvas');
      copy.width = canvas.width;
      copy.height = canvas.height;
      const context = copy.getContext('2d', { willReadFrequently: true })!;
      context.drawImage(canvas, 0, 0);
      const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
      const code = parseInt(String(colour).slice(1), 16);
      let count = 0;
      for (let i = 0; i < data.length; i += 4)
        if (
          Math.abs(data[i] - (code >> 16)) < 4 &&
          Math.abs(data[i + 1] - ((code >> 8) & 255)) < 4 &&
          Math.abs(data[i + 2] - (code & 255)) < 4
        )
          ++count;
      return count;
    },
    [hex, view],
  );
}
