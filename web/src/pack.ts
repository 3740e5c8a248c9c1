// The binary that the host appends to the page: named columns behind a JSON header, gzip, base64.
// Its writer is core/report/page_data.cpp; docs/replay-page.md describes the bytes.

export type Column = Uint8Array | Uint16Array | Uint32Array | Float32Array;
export type ColumnType = 'u8' | 'u16' | 'u32' | 'f32';

/** How a column's values are turned into what compresses well. */
export type Encoding =
  | { kind: 'plain' }
  /** The difference to the value `stride` places before (modulo the type's range). */
  | { kind: 'delta'; stride: number }
  /** Bits, exclusive-or those of the same cell in the frame before. */
  | { kind: 'cell' };

export interface BlockHeader {
  name: string;
  type: ColumnType;
  count: number;
  encoding: 'plain' | 'delta' | 'cell';
  stride?: number;
}

const magic = 'SOMASPG1';
const widths: Record<ColumnType, number> = { u8: 1, u16: 2, u32: 4, f32: 4 };

export class PackError extends Error {}

export function bytesOfBase64(text: string): Uint8Array {
  const compact = text.trim();
  const native = Uint8Array as unknown as { fromBase64?: (text: string) => Uint8Array };
  if (native.fromBase64) return native.fromBase64(compact);
  const binary = atob(compact);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

export async function gunzip(bytes: Uint8Array): Promise<Uint8Array> {
  const stream = new Blob([bytes as BlobPart]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Undoes the separation into planes: all first bytes, then all second bytes, ... */
export function unshuffle(planes: Uint8Array, width: number): Uint8Array {
  if (width === 1) return planes.slice();
  const count = planes.length / width;
  const bytes = new Uint8Array(planes.length);
  for (let b = 0; b < width; ++b)
    for (let i = 0, from = b * count; i < count; ++i) bytes[i * width + b] = planes[from + i];
  return bytes;
}

/** Of each row, the row of the same cell in the frame before, or -1. Rows ascend by (organism, id). */
export function previousRows(
  rowStart: Uint32Array,
  organism: Uint16Array | Uint8Array,
  id: Uint32Array,
): Int32Array {
  const previous = new Int32Array(id.length).fill(-1);
  for (let frame = 1; frame + 1 < rowStart.length; ++frame) {
    let old = rowStart[frame - 1];
    const oldEnd = rowStart[frame];
    for (let row = rowStart[frame]; row < rowStart[frame + 1]; ++row) {
      while (
        old < oldEnd &&
        (organism[old] < organism[row] || (organism[old] === organism[row] && id[old] < id[row]))
      )
        ++old;
      if (old < oldEnd && organism[old] === organism[row] && id[old] === id[row])
        previous[row] = old;
    }
  }
  return previous;
}

function integers(bytes: Uint8Array, type: ColumnType): Uint8Array | Uint16Array | Uint32Array {
  if (type === 'u8') return bytes;
  if (type === 'u16') return new Uint16Array(bytes.buffer, bytes.byteOffset, bytes.length / 2);
  return new Uint32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
}

export interface Pack {
  header: Record<string, unknown>;
  columns: Map<string, Column>;
  previous: Int32Array;
}

export function decodePack(bytes: Uint8Array): Pack {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (bytes.length < 12 || new TextDecoder().decode(bytes.subarray(0, 8)) !== magic)
    throw new PackError('this is no recording of this version of the page');
  const headerBytes = view.getUint32(8, true);
  const header = JSON.parse(
    new TextDecoder().decode(bytes.subarray(12, 12 + headerBytes)),
  ) as Record<string, unknown>;

  const columns = new Map<string, Column>();
  let previous: Int32Array = new Int32Array(0);
  let at = 12 + headerBytes;
  for (const block of header.blocks as BlockHeader[]) {
    const width = widths[block.type];
    const length = block.count * width;
    if (at + length > bytes.length) throw new PackError(`the recording ends within ${block.name}`);
    const values = integers(unshuffle(bytes.subarray(at, at + length), width), block.type);
    at += length;
    if (block.encoding === 'delta') {
      const stride = block.stride ?? 1;
      for (let i = stride; i < values.length; ++i) values[i] += values[i - stride];
    } else if (block.encoding === 'cell') {
      // The columns that say who is who come first, none of them encoded by cell.
      if (previous.length !== block.count)
        previous = previousRows(
          columns.get('frame.rows') as Uint32Array,
          columns.get('cell.organism') as Uint16Array,
          columns.get('cell.id') as Uint32Array,
        );
      for (let i = 0; i < values.length; ++i)
        if (previous[i] >= 0) values[i] ^= values[previous[i]];
    }
    columns.set(
      block.name,
      block.type === 'f32'
        ? new Float32Array(values.buffer, values.byteOffset, values.length)
        : values,
    );
  }
  if (at !== bytes.length) throw new PackError('the recording is longer than its header says');
  return { header, columns, previous };
}
