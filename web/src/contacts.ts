// Cells whose discs overlap.

/** Calls visit(i, j), i < j, for every overlapping pair; rows are begin .. end. */
export function overlaps(
  x: Float32Array,
  y: Float32Array,
  radius: Float32Array,
  begin: number,
  end: number,
  visit: (i: number, j: number) => void,
): void {
  let widest = 0;
  for (let i = begin; i < end; ++i) widest = Math.max(widest, radius[i]);
  if (widest === 0) return;
  const side = 2 * widest;
  const bins = new Map<number, number[]>();
  const bin = (column: number, row: number) => column * 65536 + row;
  for (let i = begin; i < end; ++i) {
    const column = Math.floor(x[i] / side);
    const row = Math.floor(y[i] / side);
    for (let dc = -1; dc <= 1; ++dc)
      for (let dr = -1; dr <= 1; ++dr)
        for (const j of bins.get(bin(column + dc, row + dr)) ?? []) {
          const reach = radius[i] + radius[j];
          if ((x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2 < reach * reach) visit(j, i);
        }
    const own = bins.get(bin(column, row));
    if (own) own.push(i);
    else bins.set(bin(column, row), [i]);
  }
}
