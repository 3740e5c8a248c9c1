// Colours that colour-blind people can tell apart.

/** Of states: Okabe and Ito (2008), as in the host's pictures; from the seventh on they return darker. */
const okabeIto = ['#E69F00', '#0072B2', '#009E73', '#CC79A7', '#56B4E9', '#F0E442'];
/** Of tables (particles), the same as in pictures on light ground. */
const tableColours = { light: ['#D55E00', '#1a1a1a', '#7F3F98'], dark: ['#FF7A2F', '#f0f0f0', '#C58BE0'] };
const causeColours = {
  light: ['#525252', '#8C510A', '#762A83', '#B2182B', '#01665E', '#2166AC'],
  dark: ['#B8B8B8', '#DFA35B', '#C79AD2', '#F4727E', '#5CC7BA', '#7FB5E6'],
};
/** Of organisms that share a world, as in the host's pictures on light ground. */
const organismColours = {
  light: ['#00504a', '#c0268b', '#7a7a7a', '#7a3b00', '#4b3fa0'],
  dark: ['#4db6ac', '#ff6ec7', '#9a9a9a', '#d39a5b', '#a79cf0'],
};
/** Tints of fields; a grid with a resource is first. */
const fieldTints = {
  light: ['#6f7f64', '#b0358f', '#1583a8', '#b8860b', '#5b53c4', '#b04a2b'],
  dark: ['#7c9468', '#e065c2', '#41b9e0', '#e2b93b', '#978ff5', '#f08a66'],
};
/** viridis, ten equal steps. */
const viridis = [
  '#440154', '#482475', '#414487', '#355f8d', '#2a788e', '#21918c', '#22a884', '#44bf70', '#7ad151',
  '#bddf26', '#fde725',
].map(channels);

export type Theme = 'light' | 'dark';
export const levels = 64;

export function channels(hex: string): [number, number, number] {
  const code = parseInt(hex.slice(1), 16);
  return [(code >> 16) & 255, (code >> 8) & 255, code & 255];
}
const hex = (rgb: number[]): string =>
  '#' + rgb.map((c) => Math.round(c).toString(16).padStart(2, '0')).join('');

export function mix(a: string, b: string, share: number): string {
  const from = channels(a);
  const to = channels(b);
  return hex(from.map((c, i) => c + (to[i] - c) * share));
}

export function stateColour(state: number): string {
  const round = Math.floor(state / okabeIto.length);
  const colour = okabeIto[state % okabeIto.length];
  return round === 0 ? colour : mix(colour, '#000000', 1 - 0.6 ** round);
}
export const tableColour = (table: number, theme: Theme): string =>
  tableColours[theme][table % tableColours[theme].length];
export const organismColour = (organism: number, theme: Theme): string =>
  organismColours[theme][organism % organismColours[theme].length];
export const causeColour = (cause: number, theme: Theme): string =>
  causeColours[theme][cause % causeColours[theme].length];
export const fieldColour = (grid: number, theme: Theme): string =>
  fieldTints[theme][grid % fieldTints[theme].length];

/** Of a share in [0, 1]; grey for what is no number. */
export function scaleColour(share: number): string {
  if (Number.isNaN(share)) return '#9a9a9a';
  const at = Math.min(Math.max(share, 0), 1) * (viridis.length - 1);
  const low = Math.min(Math.floor(at), viridis.length - 2);
  return hex(viridis[low].map((c, i) => c + (viridis[low + 1][i] - c) * (at - low)));
}
const scale = Array.from({ length: levels }, (_, i) => scaleColour(i / (levels - 1)));
/** The same in `levels` steps, so that cells share their sprites. */
export const levelColour = (share: number): string =>
  Number.isNaN(share)
    ? '#9a9a9a'
    : scale[Math.round(Math.min(Math.max(share, 0), 1) * (levels - 1))];

/** Twelve clones, then again. Neighbours differ in lightness, too. */
const cloneColours = [
  '#0072B2', '#E69F00', '#009E73', '#CC79A7', '#56B4E9', '#D55E00', '#F0E442', '#7F3F98', '#004D40',
  '#B0BEC5', '#8D4E1B', '#9CCC65',
];
export const cloneColour = (clone: number): string => cloneColours[clone % cloneColours.length];
