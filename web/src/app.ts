// The page: what is shown, and what happens when something is pressed.
import { Camera } from './camera';
import { ChartRow, viewNames } from './chart_row';
import { scaleColour, type Theme } from './colours';
import { byId, h } from './dom';
import { download, paintPicture } from './exporter';
import { number, plural } from './format';
import { Inspector } from './inspector';
import { icon, type IconName } from './icons';
import { listen, type Key } from './keyboard';
import { Clones, commonRange, defaultCloneStep, paintOf, type Paint } from './paint';
import { formatLink, parseLink } from './permalink';
import { Player, speeds } from './player';
import type { CellName, Recording } from './recording';
import { SidePanel } from './side_panel';
import { extentOf, Stage } from './stage';
import { cellCsv, cellTable } from './table';

const buttonIcons: [string, IconName][] = [
  ['to-start', 'first'], ['back', 'back'], ['play', 'play'], ['forward', 'forward'], ['to-end', 'last'],
];

/** One recording on the page. */
interface View {
  recording: Recording;
  stage: Stage;
  canvas: HTMLCanvasElement;
  caption: HTMLElement;
  clones: Clones;
  paint: Paint;
}

export class App {
  private readonly views: View[];
  private readonly camera = new Camera();
  private readonly player: Player;
  private readonly stateNames: string[];
  private readonly charts: ChartRow;
  private readonly inspector: Inspector;
  private readonly side: SidePanel;
  private selection: { view: number; cell: CellName } | undefined;
  private theme: Theme;
  private stale = true;
  private asked = false;
  private before = 0;
  private linkTimer = 0;
  private readonly keys: Key[];

  constructor(recordings: Recording[]) {
    this.stateNames = [...new Set(recordings.flatMap((recording) => recording.stateNames))];
    const causes = [...new Set(recordings.flatMap((recording) => [...recording.header.causes, 'wound']))];
    const first = Math.min(...recordings.map((recording) => recording.firstStep));
    const last = Math.max(...recordings.map((recording) => recording.lastStep));
    this.player = new Player(first, last);
    this.theme = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
    this.views = recordings.map((recording, v) => this.makeView(recording, v, causes));
    this.side = new SidePanel(recordings, {
      changed: () => {
        this.repaint();
      },
      clonesHere: () => {
        for (const view of this.views) view.clones = new Clones(view.recording, this.player.step);
        this.repaint();
      },
    });
    this.inspector = new Inspector(
      byId('cell'),
      {
        select: (cell) => {
          this.select({ view: this.selection?.view ?? 0, cell });
        },
        seek: (step) => {
          this.seek(step);
        },
      },
      this.stateIndex,
    );
    this.charts = new ChartRow(byId('charts'), recordings, causes, this.stateIndex, (step) => {
      this.seek(step);
    });
    this.keys = this.makeKeys();
  }

  start(): void {
    this.writeTitles();
    this.wire();
    this.setTheme(this.theme);
    this.draw(); // the captions take their room
    this.fit();
    this.followLink();
    new ResizeObserver(() => {
      this.charts.resize();
      this.changed();
    }).observe(byId('app'));
    // Words that grow by a line leave the stages less room: drawn anew at once, before it is seen.
    const stages = new ResizeObserver(() => { this.drawStages(); });
    for (const { canvas } of this.views) stages.observe(canvas);
    byId('app').setAttribute('aria-busy', 'false');
    this.changed();
  }

  // ---- making ------------------------------------------------------------------------------------

  private makeView(recording: Recording, index: number, causes: string[]): View {
    const canvas = h('canvas', { role: 'img' });
    const caption = h('figcaption');
    byId('stages').append(
      h('figure', { class: 'view' }, caption, h('div', { class: 'stage' }, canvas)),
    );
    const clones = new Clones(recording, defaultCloneStep(recording));
    this.watchPointer(canvas, index);
    return {
      recording,
      stage: new Stage(recording, this.camera, causes),
      canvas,
      caption,
      clones,
      paint: { colour: () => '#888888', kinds: [] },
    };
  }

  private readonly stateIndex = (name: string): number => this.stateNames.indexOf(name);

  private writeTitles(): void {
    const titles = this.views.map(({ recording }) => recording.header.title);
    const title = [...new Set(titles)].join(' and ');
    byId('title').textContent = title;
    document.title = `${title} · SOMAS replay`;
    byId('subtitle').textContent =
      this.views.length === 1
        ? this.subtitleOf(this.views[0].recording)
        : `${this.views.length} lives side by side, step by step`;
    const { first, last } = this.player;
    byId('last').textContent = `of ${last}`;
    for (const id of ['scrub', 'step']) {
      const input = byId<HTMLInputElement>(id);
      input.min = String(first);
      input.max = String(last);
    }
    byId('speed').append(...speeds.map((speed) => h('option', { value: String(speed) }, `${speed} steps/s`)));
    byId('keys').append(
      ...this.keys.flatMap(({ shown, does }) => [h('dt', {}, h('kbd', {}, shown)), h('dd', {}, does)]),
    );
  }

  private subtitleOf(recording: Recording): string {
    const { subtitle, changes } = recording.header;
    return changes.length > 0 ? `${subtitle}; what if ${changes.join(', ')}` : subtitle;
  }

  private wire(): void {
    const on = (id: string, event: string, run: (event: Event) => void) => {
      byId(id).addEventListener(event, run);
    };
    for (const [id, name] of buttonIcons) byId(id).append(icon(name));
    const value = (event: Event) => Number((event.target as HTMLInputElement).value);
    on('play', 'click', () => { this.togglePlay(); });
    on('to-start', 'click', () => { this.seek(this.player.first); });
    on('to-end', 'click', () => { this.seek(this.player.last); });
    on('back', 'click', () => { this.seek(this.player.step - 1); });
    on('forward', 'click', () => { this.seek(this.player.step + 1); });
    on('scrub', 'input', (event) => { this.seek(value(event)); });
    on('step', 'change', (event) => { this.seek(value(event)); });
    on('speed', 'change', (event) => { this.player.speed = value(event); });
    on('theme', 'click', () => { this.setTheme(this.theme === 'dark' ? 'light' : 'dark'); });
    on('export', 'click', () => { this.exportPicture(); });
    on('copy-link', 'click', () => { void this.copyLink(); });
    on('open-help', 'click', () => { byId<HTMLDialogElement>('help').showModal(); });
    on('open-table', 'click', () => { this.openTable(); });
    on('table-csv', 'click', () => { this.saveCsv(); });
    byId<HTMLSelectElement>('speed').value = String(this.player.speed);
    window.addEventListener('hashchange', () => { this.followLink(); });
    listen(this.keys, () => byId<HTMLInputElement>('keys-on').checked);
  }

  private makeKeys(): Key[] {
    const key = (keys: string[], shown: string, does: string, run: (event: KeyboardEvent) => void): Key => ({
      keys, shown, does, run,
    });
    const jump = (event: KeyboardEvent) => (event.shiftKey ? 10 : 1);
    const pan = (dx: number, dy: number) => () => { this.camera.pan(dx, dy); this.changed(); };
    return [
      key([' '], 'space', 'play, pause', () => { this.togglePlay(); }),
      key(['ArrowRight'], '→, shift →', 'one step, ten steps on', (e) => { this.seek(this.player.step + jump(e)); }),
      key(['ArrowLeft'], '←, shift ←', 'one step, ten steps back', (e) => { this.seek(this.player.step - jump(e)); }),
      key(['Home'], 'Home', 'first step', () => { this.seek(this.player.first); }),
      key(['End'], 'End', 'last step', () => { this.seek(this.player.last); }),
      key([']'], ']', 'faster', () => { this.changeSpeed(1); }),
      key(['['], '[', 'slower', () => { this.changeSpeed(-1); }),
      key(['+', '='], '+', 'zoom in', () => { this.zoom(1.25); }),
      key(['-'], '-', 'zoom out', () => { this.zoom(0.8); }),
      key(['0', 'f'], '0, f', 'see everything', () => { this.fit(); }),
      key(['a'], 'a', 'look left', pan(60, 0)),
      key(['d'], 'd', 'look right', pan(-60, 0)),
      key(['w'], 'w', 'look up', pan(0, 60)),
      key(['s'], 's', 'look down', pan(0, -60)),
      key(['n'], 'n', 'select the next cell', () => { this.selectNext(1); }),
      key(['p'], 'p', 'select the previous cell', () => { this.selectNext(-1); }),
      key(['m'], 'm', 'select the mother', () => { this.selectMother(); }),
      key(['Escape'], 'Esc', 'select nothing', () => { this.select(undefined); }),
      key(['c'], 'c', 'colour by the next quantity', () => { this.side.nextColour(); }),
      key(['t'], 't', 'cells of this step as a table', () => { this.openTable(); }),
      key(['e'], 'e', 'save a picture', () => { this.exportPicture(); }),
      key(['l'], 'l', 'copy a link to this step', () => { void this.copyLink(); }),
      key(['o'], 'o', 'light or dark', () => { this.setTheme(this.theme === 'dark' ? 'light' : 'dark'); }),
      key(['?', 'h'], '?, h', 'this help', () => { byId<HTMLDialogElement>('help').showModal(); }),
    ];
  }

  // ---- doing -------------------------------------------------------------------------------------

  private seek(step: number): void {
    if (!Number.isFinite(step)) return;
    this.player.playing = false;
    this.player.seek(step);
    this.changed();
  }

  private togglePlay(): void {
    this.player.toggle();
    this.before = performance.now();
    this.changed();
  }

  private changeSpeed(by: number): void {
    this.player.faster(by);
    byId<HTMLSelectElement>('speed').value = String(this.player.speed);
    this.say(`${this.player.speed} steps a second`);
  }

  private select(selection: { view: number; cell: CellName } | undefined): void {
    this.selection = selection;
    this.side.showFamily(selection !== undefined);
    this.changed();
  }

  private selectNext(by: number): void {
    const view = this.selection?.view ?? 0;
    const { recording } = this.views[view];
    const frame = recording.frameAt(this.player.step);
    const begin = recording.rowStart[frame];
    const count = recording.rowStart[frame + 1] - begin;
    if (count === 0) return;
    const row = this.selection ? recording.rowOf(frame, this.selection.cell) : -1;
    const place = row < 0 ? (by > 0 ? 0 : count - 1) : (row - begin + by + count) % count;
    const next = begin + place;
    this.select({ view, cell: { organism: recording.organism[next], id: recording.id[next] } });
    this.say(`cell ${recording.id[next]}`);
  }

  private selectMother(): void {
    if (!this.selection) return;
    const { view, cell } = this.selection;
    const mother = this.views[view].recording.motherOf(cell);
    if (mother) this.select({ view, cell: mother });
  }

  private zoom(factor: number): void {
    const { clientWidth, clientHeight } = this.views[0].canvas;
    this.camera.zoom(factor, clientWidth / 2, clientHeight / 2, clientWidth, clientHeight);
    this.changed();
  }

  private fit(): void {
    const boxes = this.views.map(({ recording }) => extentOf(recording));
    const { clientWidth, clientHeight } = this.views[0].canvas;
    this.camera.fit(
      {
        left: Math.min(...boxes.map((box) => box.left)),
        right: Math.max(...boxes.map((box) => box.right)),
        bottom: Math.min(...boxes.map((box) => box.bottom)),
        top: Math.max(...boxes.map((box) => box.top)),
      },
      clientWidth,
      clientHeight,
    );
    this.changed();
  }

  private setTheme(theme: Theme): void {
    this.theme = theme;
    document.documentElement.dataset.theme = theme;
    this.charts.draw(theme);
    this.side.draw(theme);
    this.repaint();
  }

  private exportPicture(): void {
    const { clientWidth: width, clientHeight: height } = this.views[0].canvas;
    const picture = paintPicture(
      this.views.map((view, v) => ({
        title: view.recording.header.title,
        caption: `${this.subtitleOf(view.recording)}; ${this.captionOf(view)}`,
        draw: (c, w, hh) => {
          view.stage.draw(c, w, hh, this.sceneOf(view, v));
        },
      })),
      this.side.legend(this.views[0].paint, number, scaleColour),
      { width, height },
      this.theme,
    );
    picture.toBlob((blob) => {
      if (blob) download(`somas-step-${String(this.player.step).padStart(5, '0')}.png`, blob);
    });
    this.say('picture saved');
  }

  private openTable(): void {
    const view = this.views[this.selection?.view ?? 0];
    const frame = view.recording.frameAt(this.player.step);
    byId('table-title').textContent = `${view.recording.header.title}: cells after step ${view.recording.steps[frame]}`;
    byId('table-rows').replaceChildren(cellTable(view.recording, frame));
    byId<HTMLDialogElement>('table').showModal();
  }

  private saveCsv(): void {
    const { recording } = this.views[this.selection?.view ?? 0];
    const frame = recording.frameAt(this.player.step);
    download(`somas-cells-${recording.steps[frame]}.csv`, new Blob([cellCsv(recording, frame)], { type: 'text/csv' }));
  }

  // ---- links -------------------------------------------------------------------------------------

  private followLink(): void {
    const link = parseLink(location.hash);
    if (link.colour) this.side.setColour(link.colour);
    if (link.layers) this.side.setLayers(link.layers);
    if (link.camera) Object.assign(this.camera, link.camera);
    if (link.step !== undefined) this.player.seek(link.step);
    if (link.cell && link.cell.view < this.views.length)
      this.selection = { view: link.cell.view, cell: { organism: link.cell.organism, id: link.cell.id } };
    this.side.showFamily(this.selection !== undefined);
    this.repaint();
  }

  private link(): string {
    const { x, y, scale } = this.camera;
    return formatLink({
      step: this.player.step,
      ...(this.selection ? { cell: { view: this.selection.view, ...this.selection.cell } } : {}),
      colour: this.side.colour,
      layers: [...this.side.layers],
      camera: { x, y, scale },
    });
  }

  private async copyLink(): Promise<void> {
    history.replaceState(null, '', this.link());
    try {
      await navigator.clipboard.writeText(location.href);
      this.say('link copied');
    } catch {
      this.say('the link stands in the address bar');
    }
  }

  // ---- showing -----------------------------------------------------------------------------------

  /** Colours may have changed, too. */
  private repaint(): void {
    const by = this.side.colour;
    const range = commonRange(this.views.map(({ recording }) => recording.attribute(by)));
    for (const view of this.views)
      view.paint = paintOf(view.recording, by, view.clones, this.stateIndex, range, this.theme);
    this.side.drawLegend(this.views.map(({ paint }) => paint));
    this.changed();
  }

  private changed(): void {
    this.stale = true;
    this.ask();
  }

  private ask(): void {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame((now) => {
      this.asked = false;
      this.tick(now);
    });
  }

  private tick(now: number): void {
    if (this.player.playing) {
      if (this.player.advance(now - this.before)) this.stale = true;
      this.before = now;
    }
    if (this.stale) this.draw();
    if (this.player.playing) this.ask();
  }

  private draw(): void {
    this.stale = false;
    this.views.forEach((view, v) => {
      this.writeCaption(view, v);
    });
    this.drawTransport();
    this.charts.show(this.player.step);
    this.drawInspector();
    // The stages get the room that is left.
    this.drawStages();
    this.keepLink();
  }

  private drawStages(): void {
    this.views.forEach((view, v) => {
      this.drawView(view, v);
    });
  }

  private sceneOf(view: View, index: number) {
    const frame = view.recording.frameAt(this.player.step);
    return {
      frame,
      step: Math.min(this.player.step, view.recording.lastStep),
      paint: view.paint,
      layers: this.side.layers,
      selected: this.selection?.view === index ? this.selection.cell : undefined,
      family: this.side.family,
      theme: this.theme,
    };
  }

  private drawView(view: View, index: number): void {
    const { canvas } = view;
    const { clientWidth: width, clientHeight: height } = canvas;
    if (width === 0 || height === 0) return;
    const ratio = Math.min(window.devicePixelRatio, 2);
    const [w, hh] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (canvas.width !== w || canvas.height !== hh) {
      canvas.width = w;
      canvas.height = hh;
    }
    const c = canvas.getContext('2d', { alpha: false })!;
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    const scene = this.sceneOf(view, index);
    if (this.side.follow) this.followOrganism(scene.frame, index);
    view.stage.draw(c, width, height, scene);
  }

  private writeCaption(view: View, index: number): void {
    const text = this.captionOf(view);
    const lines = [h('span', { class: 'counts' }, text)];
    if (this.views.length > 1) {
      const name = `${viewNames[index]}: ${view.recording.header.title}`;
      lines.unshift(h('strong', {}, name), h('span', { class: 'muted' }, this.subtitleOf(view.recording)));
    }
    view.caption.replaceChildren(...lines);
    view.canvas.setAttribute('aria-label', `${view.recording.header.title}. ${text}`);
  }

  private captionOf({ recording }: View): string {
    const frame = recording.frameAt(this.player.step);
    const counts = recording.stateNames.map(() => 0);
    for (let row = recording.rowStart[frame]; row < recording.rowStart[frame + 1]; ++row)
      ++counts[recording.stateAt(row)];
    const total = recording.rowStart[frame + 1] - recording.rowStart[frame];
    const parts = counts.map((count, s) => `${count} ${recording.stateNames[s]}`).join(', ');
    const ended = this.player.step > recording.lastStep ? ' (the life has ended)' : '';
    return `step ${recording.steps[frame]}${ended}: ${plural(total, 'cell')}${total > 0 ? `, ${parts}` : ''}`;
  }

  private followOrganism(frame: number, index: number): void {
    if (index > 0) return;
    const { recording } = this.views[0];
    const begin = recording.rowStart[frame];
    const end = recording.rowStart[frame + 1];
    if (begin === end) return;
    let [x, y] = [0, 0];
    for (let row = begin; row < end; ++row) {
      x += recording.x[row];
      y += recording.y[row];
    }
    this.camera.x = x / (end - begin);
    this.camera.y = y / (end - begin);
  }

  private drawTransport(): void {
    const { step, playing } = this.player;
    byId<HTMLInputElement>('scrub').value = String(step);
    const field = byId<HTMLInputElement>('step');
    if (document.activeElement !== field) field.value = String(step);
    const play = byId('play');
    const name = playing ? 'Pause' : 'Play';
    if (play.getAttribute('aria-label') === name) return;
    play.setAttribute('aria-label', name);
    play.replaceChildren(icon(playing ? 'pause' : 'play'));
  }

  private drawInspector(): void {
    if (!this.selection) {
      this.inspector.clear();
      return;
    }
    const { view, cell } = this.selection;
    const { recording } = this.views[view];
    const ink = this.theme === 'dark' ? '#eef1f4' : '#15181c';
    this.inspector.show(recording, view, cell, recording.frameAt(this.player.step), ink);
  }

  /** The address follows, but not at every step of a playing life. */
  private keepLink(): void {
    window.clearTimeout(this.linkTimer);
    this.linkTimer = window.setTimeout(() => {
      history.replaceState(null, '', this.link());
      if (!this.player.playing) this.say(this.captionOf(this.views[0]));
    }, 300);
  }

  private say(text: string): void {
    byId('status').textContent = text;
  }

  private watchPointer(canvas: HTMLCanvasElement, index: number): void {
    let moved = 0;
    canvas.addEventListener('pointerdown', (event) => {
      moved = 0;
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener('pointermove', (event) => {
      if (!(event.buttons & 1)) return;
      moved += Math.abs(event.movementX) + Math.abs(event.movementY);
      this.camera.pan(event.movementX, event.movementY);
      this.changed();
    });
    canvas.addEventListener('pointerup', (event) => {
      if (moved > 4) return;
      const { recording, stage } = this.views[index];
      const cell = stage.pick(
        event.offsetX, event.offsetY, canvas.clientWidth, canvas.clientHeight,
        recording.frameAt(this.player.step),
      );
      this.select(cell && { view: index, cell });
    });
    canvas.addEventListener('dblclick', () => {
      this.fit();
    });
    canvas.addEventListener(
      'wheel',
      (event) => {
        event.preventDefault();
        const factor = Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015));
        this.camera.zoom(factor, event.offsetX, event.offsetY, canvas.clientWidth, canvas.clientHeight);
        this.changed();
      },
      { passive: false },
    );
  }
}

