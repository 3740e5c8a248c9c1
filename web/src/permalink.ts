// What the address bar keeps: the step, the selection and the look of the page.
export interface Link {
  step?: number;
  /** Organism and id, and which of the recordings. */
  cell?: { view: number; organism: number; id: number };
  colour?: string;
  /** Names of the layers that are on. */
  layers?: string[];
  /** Centre and pixels a length. */
  camera?: { x: number; y: number; scale: number };
}

const numbers = (text: string, count: number): number[] | undefined => {
  const parts = text.split(',').map(Number);
  return parts.length === count && parts.every(Number.isFinite) ? parts : undefined;
};

export function parseLink(hash: string): Link {
  const parameters = new URLSearchParams(hash.replace(/^#/, ''));
  const link: Link = {};
  const step = parameters.get('step');
  if (step !== null && /^\d+$/.test(step)) link.step = Number(step);
  const cell = numbers(parameters.get('cell') ?? '', 3);
  if (cell?.every((n) => Number.isInteger(n) && n >= 0))
    link.cell = { view: cell[0], organism: cell[1], id: cell[2] };
  const colour = parameters.get('colour');
  if (colour) link.colour = colour;
  const layers = parameters.get('layers');
  if (layers !== null) link.layers = layers === '' ? [] : layers.split(',');
  const camera = numbers(parameters.get('view') ?? '', 3);
  if (camera && camera[2] > 0) link.camera = { x: camera[0], y: camera[1], scale: camera[2] };
  return link;
}

export function formatLink(link: Link): string {
  const parts: string[] = [];
  const put = (name: string, value: string) => parts.push(`${name}=${value}`);
  if (link.step !== undefined) put('step', String(link.step));
  if (link.cell) put('cell', `${link.cell.view},${link.cell.organism},${link.cell.id}`);
  if (link.colour) put('colour', encodeURIComponent(link.colour));
  if (link.layers) put('layers', link.layers.map(encodeURIComponent).join(','));
  if (link.camera) {
    const round = (n: number) => String(Number(n.toPrecision(5)));
    put('view', [link.camera.x, link.camera.y, link.camera.scale].map(round).join(','));
  }
  return '#' + parts.join('&');
}
