// Writes what the host writes: small recordings for the tests.
import type { BlockHeader, ColumnType } from '../src/pack';

const widths: Record<ColumnType, number> = { u8: 1, u16: 2, u32: 4, f32: 4 };

export interface Block {
  name: string;
  type: ColumnType;
  values: number[];
  encoding?: 'plain' | 'delta' | 'cell';
  stride?: number;
}

function bitsOf(type: ColumnType, value: number): number {
  if (type !== 'f32') return value >>> 0;
  const view = new DataView(new ArrayBuffer(4));
  view.setFloat32(0, value);
  return view.getUint32(0);
}

function planesOf(block: Block, previous: number[]): Uint8Array {
  const width = widths[block.type];
  const bits = block.values.map((value) => bitsOf(block.type, value));
  const stride = block.stride ?? 1;
  const coded = bits.map((value, i) => {
    if (block.encoding === 'delta' && i >= stride) return (value - bits[i - stride]) >>> 0;
    if (block.encoding === 'cell' && previous[i] >= 0) return (value ^ bits[previous[i]]) >>> 0;
    return value;
  });
  const bytes = new Uint8Array(bits.length * width);
  coded.forEach((value, i) => {
    for (let b = 0; b < width; ++b) bytes[b * bits.length + i] = (value >>> (8 * b)) & 255;
  });
  return bytes;
}

/** `previous`: of each row of cells, the row of the same cell in the frame before, or -1. */
export function encodePack(
  header: Record<string, unknown>,
  blocks: Block[],
  previous: number[] = [],
): Uint8Array {
  const headers: BlockHeader[] = blocks.map(({ name, type, values, encoding, stride }) => ({
    name,
    type,
    count: values.length,
    encoding: encoding ?? 'plain',
    ...(stride === undefined ? {} : { stride }),
  }));
  const json = new TextEncoder().encode(JSON.stringify({ ...header, blocks: headers }));
  const parts = [
    new TextEncoder().encode('SOMASPG1'),
    new Uint8Array(new Uint32Array([json.length]).buffer),
    json,
    ...blocks.map((block) => planesOf(block, previous)),
  ];
  const bytes = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}
