// What cells are coloured by, and which layers are on.
import { fieldColour, organismColour, scaleColour, tableColour, type Theme } from './colours';
import { byId, h, swatch } from './dom';
import type { Legend } from './exporter';
import { number, words } from './format';
import type { Paint } from './paint';
import type { AttributeGroup, Recording } from './recording';
import { layerOfGrid, layerOfOrganism, layerOfTable } from './stage';

interface Layer {
  name: string;
  label: string;
  on: boolean;
  colour?: (theme: Theme) => string;
}

const groups: Record<AttributeGroup, string> = {
  cell: 'quantities',
  damage: 'damage',
  value: 'declared by environments',
  input: 'sensed',
  output: 'controller outputs',
};

export class SidePanel {
  colour = 'state';
  readonly layers = new Set<string>();
  family = false;
  follow = false;
  private readonly known: Layer[];
  private readonly select = byId<HTMLSelectElement>('colour');
  private readonly familyBox = h('input', { type: 'checkbox', id: 'family' });

  constructor(
    private readonly recordings: Recording[],
    private readonly on: { changed: () => void; clonesHere: () => void },
  ) {
    this.known = this.layersOf(recordings);
    for (const layer of this.known) if (layer.on) this.layers.add(layer.name);
    this.fillSelect();
    this.select.addEventListener('change', () => {
      this.setColour(this.select.value);
      on.changed();
    });
    byId('clones-here').addEventListener('click', on.clonesHere);
    this.familyBox.addEventListener('change', () => {
      this.family = this.familyBox.checked;
      on.changed();
    });
  }

  setColour(name: string): void {
    const known = [...this.select.options].some((option) => option.value === name);
    if (!known) return;
    this.colour = name;
    this.select.value = name;
    byId('clones-here').hidden = name !== 'clone';
  }

  nextColour(): void {
    const names = [...this.select.options].map((option) => option.value);
    this.setColour(names[(names.indexOf(this.colour) + 1) % names.length]);
    this.on.changed();
  }

  setLayers(names: string[]): void {
    this.layers.clear();
    for (const { name } of this.known) if (names.includes(name)) this.layers.add(name);
    for (const box of byId('layers').querySelectorAll<HTMLInputElement>('input[data-layer]'))
      box.checked = this.layers.has(box.dataset.layer!);
  }

  showFamily(possible: boolean): void {
    this.familyBox.disabled = !possible;
  }

  draw(theme: Theme): void {
    const box = (label: string, input: HTMLInputElement, mark?: string) =>
      h('label', {}, input, ...(mark ? [swatch(mark)] : []), label);
    const follow = h('input', { type: 'checkbox', id: 'follow', checked: this.follow });
    follow.addEventListener('change', () => {
      this.follow = follow.checked;
      this.on.changed();
    });
    byId('layers').replaceChildren(
      ...this.known.map((layer) => {
        const input = h('input', {
          type: 'checkbox',
          'data-layer': layer.name,
          checked: this.layers.has(layer.name),
        });
        input.addEventListener('change', () => {
          if (input.checked) this.layers.add(layer.name);
          else this.layers.delete(layer.name);
          this.on.changed();
        });
        return box(layer.label, input, layer.colour?.(theme));
      }),
      box('only descendants of the selected cell', this.familyBox),
      box('follow the organism', follow),
    );
  }

  drawLegend(paints: Paint[]): void {
    const scale = paints[0].scale;
    const element = byId('colour-legend');
    if (scale) {
      const stops = Array.from({ length: 11 }, (_, i) => scaleColour(i / 10)).join(', ');
      const ramp = h('div', { class: 'ramp' });
      ramp.style.background = `linear-gradient(90deg, ${stops})`;
      element.replaceChildren(
        ramp,
        h('div', { class: 'ends' }, h('span', {}, number(scale.low)), h('span', {}, number(scale.high))),
      );
      return;
    }
    element.replaceChildren(
      h('ul', {}, ...this.kinds(paints).map(({ colour, label }) => h('li', {}, swatch(colour), label))),
    );
  }

  legend(paint: Paint, text: (value: number) => string, colour: (share: number) => string): Legend {
    const title = this.select.selectedOptions[0].textContent;
    if (!paint.scale) return { title, kinds: paint.kinds };
    const { low, high } = paint.scale;
    return { title, kinds: [], scale: { low: text(low), high: text(high), colour } };
  }

  private kinds(paints: Paint[]): { colour: string; label: string }[] {
    const kinds = paints.flatMap((paint) => paint.kinds);
    return kinds.filter((kind, i) => kinds.findIndex(({ label }) => label === kind.label) === i);
  }

  private fillSelect(): void {
    const option = (value: string, label: string) => h('option', { value }, label);
    this.select.append(option('state', 'state'), option('clone', 'clone'));
    if (this.recordings.some(({ header }) => header.organisms.length > 1))
      this.select.append(option('organism', 'organism'));
    for (const group of Object.keys(groups) as AttributeGroup[]) {
      const names = new Set(
        this.recordings.flatMap(({ attributes }) =>
          attributes.filter((each) => each.group === group).map(({ name }) => name),
        ),
      );
      if (names.size === 0) continue;
      this.select.append(
        h('optgroup', { label: groups[group] }, ...[...names].map((name) => option(name, words(name)))),
      );
    }
  }

  private layersOf(recordings: Recording[]): Layer[] {
    const layers: Layer[] = [
      { name: 'cells', label: 'cells', on: true },
      { name: 'actions', label: 'marks of actions', on: true },
      { name: 'contacts', label: 'contacts (overlapping cells)', on: false },
      { name: 'deaths', label: 'deaths of the last 12 steps', on: true },
    ];
    const add = (layer: Layer) => {
      if (!layers.some(({ name }) => name === layer.name)) layers.push(layer);
    };
    for (const recording of recordings) {
      const { header } = recording;
      // Alone in its world an organism needs no outline.
      if (header.organisms.length > 1)
        header.organisms.forEach((_, o) => {
          add({
            name: layerOfOrganism(o),
            label: `outline of ${recording.organismName(o)}`,
            on: true,
            colour: (theme) => organismColour(o, theme),
          });
        });
      if (header.outlines.length > 0) add({ name: 'outlines', label: 'outlines', on: true });
      header.tables.forEach((name, t) => {
        add({ name: layerOfTable(name), label: words(name), on: true, colour: (theme) => tableColour(t, theme) });
      });
      header.grids.forEach((grid, g) => {
        add({
          name: layerOfGrid(grid.name),
          label: words(grid.name),
          on: grid.organism === undefined,
          colour: (theme) => fieldColour(g, theme),
        });
      });
    }
    return layers;
  }
}
