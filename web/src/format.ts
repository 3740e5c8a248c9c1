// Numbers for people.

/** Four significant digits, no exponent where it can be helped. */
export function number(value: number): string {
  if (Number.isNaN(value)) return 'none';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(2);
  return String(Number(value.toPrecision(4)));
}

export const plural = (count: number, word: string): string =>
  `${count} ${word}${count === 1 ? '' : 's'}`;

/** "refused_division" and "morphogen.0" as words. */
export const words = (name: string): string => name.replaceAll('_', ' ');
