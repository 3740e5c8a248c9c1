import { gzipSync } from 'node:zlib';
import { describe, expect, it } from 'vitest';

import { bytesOfBase64, decodePack, gunzip, previousRows, unshuffle } from '../src/pack';
import { encodePack } from './encode';
import { lifeBlocks, lifeHeader, previous } from './life';

describe('a pack', () => {
  it('gives back every column, whatever its encoding', () => {
    const pack = decodePack(encodePack(lifeHeader, lifeBlocks(), previous));
    for (const { name, values } of lifeBlocks()) expect([...pack.columns.get(name)!], name).toEqual(values);
    expect([...pack.previous]).toEqual(previous);
    expect(pack.header.title).toBe('tiny');
  });

  it('survives base64 and gzip', async () => {
    const bytes = encodePack(lifeHeader, lifeBlocks(), previous);
    const text = gzipSync(bytes).toString('base64');
    expect(await gunzip(bytesOfBase64(`\n${text}\n`))).toEqual(bytes);
  });

  it('refuses bytes that are something else, cut off, or too many', () => {
    const bytes = encodePack(lifeHeader, lifeBlocks(), previous);
    const other = bytes.slice();
    other[7] += 1;
    expect(() => decodePack(other)).toThrow('no recording of this version');
    expect(() => decodePack(new Uint8Array(3))).toThrow('no recording of this version');
    expect(() => decodePack(bytes.subarray(0, bytes.length - 1))).toThrow('ends within grid.0');
    expect(() => decodePack(new Uint8Array([...bytes, 0]))).toThrow('longer than its header says');
  });

  it('keeps the bits of floats, not-a-number included', () => {
    const values = [0.1, -0, 3.4028234663852886e38, NaN].map(Math.fround);
    const pack = decodePack(encodePack({}, [{ name: 'a', type: 'f32', values }]));
    expect([...pack.columns.get('a')!]).toEqual(values);
  });

  it('counts differences modulo the range of the type', () => {
    const values = [250, 3, 255, 0];
    const pack = decodePack(encodePack({}, [{ name: 'a', type: 'u8', values, encoding: 'delta', stride: 2 }]));
    expect([...pack.columns.get('a')!]).toEqual(values);
  });
});

describe('unshuffle', () => {
  it('joins the planes of bytes', () => {
    expect([...unshuffle(new Uint8Array([1, 2, 3, 11, 12, 13]), 2)]).toEqual([1, 11, 2, 12, 3, 13]);
  });
});

describe('the row of a cell a frame before', () => {
  it('is found by organism and id, past births and deaths', () => {
    // Frames: (0,1) (0,4) (1,1) | (0,4) (0,5) (1,1) | nobody | (1,1)
    const rows = new Uint32Array([0, 3, 6, 6, 7]);
    const organism = new Uint16Array([0, 0, 1, 0, 0, 1, 1]);
    const id = new Uint32Array([1, 4, 1, 4, 5, 1, 1]);
    expect([...previousRows(rows, organism, id)]).toEqual([-1, -1, -1, 1, -1, 2, -1]);
  });
});
