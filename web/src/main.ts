// Finds the recordings that the host put into the page, and shows them.
import 'uplot/dist/uPlot.min.css';
import './style.css';

import { App } from './app';
import { h } from './dom';
import { bytesOfBase64, decodePack, gunzip } from './pack';
import { Recording } from './recording';

async function load(): Promise<Recording[]> {
  const elements = [...document.querySelectorAll('script[type="application/x-somas-recording"]')];
  if (elements.length === 0)
    throw new Error('There is no recording in this page. `somas-host replay RUN --html FILE` writes one.');
  const recordings: Recording[] = [];
  for (const element of elements) {
    const bytes = await gunzip(bytesOfBase64(element.textContent));
    element.remove(); // its text is no longer needed
    recordings.push(new Recording(decodePack(bytes)));
  }
  return recordings;
}

try {
  const app = new App(await load());
  app.start();
} catch (error) {
  const text = error instanceof Error ? error.message : String(error);
  document.getElementById('app')?.replaceChildren(
    h('div', { class: 'failure', role: 'alert' }, h('h2', {}, 'This replay cannot be shown'), h('p', {}, text)),
  );
}
