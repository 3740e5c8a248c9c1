import { describe, expect, it } from 'vitest';

import { Camera, roundLength } from '../src/camera';
import { alignLines } from '../src/charts';
import { channels, levelColour, mix, scaleColour, stateColour } from '../src/colours';
import { overlaps } from '../src/contacts';
import { number, plural, words } from '../src/format';
import { Clones, commonRange, defaultCloneStep, paintOf } from '../src/paint';
import { formatLink, parseLink } from '../src/permalink';
import { Player } from '../src/player';
import { cellCsv } from '../src/table';
import { extentOf } from '../src/stage';
import { tinyLife } from './life';

describe('the camera', () => {
  it('goes from world to screen and back, y upwards', () => {
    const camera = new Camera();
    camera.x = 2;
    camera.y = 3;
    camera.scale = 10;
    expect(camera.toScreen(3, 4, 200, 100)).toEqual([110, 40]);
    expect(camera.toWorld(110, 40, 200, 100)).toEqual([3, 4]);
  });

  it('zooms about the pointer, within limits', () => {
    const camera = new Camera();
    const before = camera.toWorld(30, 70, 200, 100);
    camera.zoom(2, 30, 70, 200, 100);
    expect(camera.scale).toBe(8);
    expect(camera.toWorld(30, 70, 200, 100)).toEqual(before);
    camera.zoom(1e9, 0, 0, 200, 100);
    expect(camera.scale).toBe(camera.most);
  });

  it('pans with the pointer and fits a box', () => {
    const camera = new Camera();
    camera.fit({ left: -10, right: 10, bottom: 0, top: 10 }, 200, 200, 1);
    expect([camera.x, camera.y, camera.scale]).toEqual([0, 5, 10]);
    camera.pan(20, 10);
    expect([camera.x, camera.y]).toEqual([-2, 6]);
  });

  it('has scale bars of round length', () => {
    expect([0.3, 1, 4.9, 5, 99].map(roundLength)).toEqual([0.2, 1, 2, 5, 50]);
  });
});

describe('the player', () => {
  it('moves by whole steps and stops at the end', () => {
    const player = new Player(5, 20);
    expect(player.advance(100)).toBe(false);
    player.speed = 10;
    player.toggle();
    expect(player.advance(50)).toBe(false);
    expect(player.advance(50)).toBe(true);
    expect(player.step).toBe(6);
    player.speed = 1000;
    expect(player.advance(200)).toBe(true);
    expect([player.step, player.playing]).toEqual([20, false]);
    player.toggle();
    expect([player.step, player.playing]).toEqual([5, true]);
  });

  it('takes a long pause for no time', () => {
    const player = new Player(0, 1000);
    player.speed = 10;
    player.toggle();
    player.advance(60_000);
    expect(player.step).toBe(2);
  });

  it('keeps to the life', () => {
    const player = new Player(5, 20);
    player.seek(99);
    expect(player.step).toBe(20);
    player.seek(-1);
    expect(player.step).toBe(5);
    for (let i = 0; i < 20; ++i) player.faster(1);
    expect(player.speed).toBe(480);
    player.faster(-1);
    expect(player.speed).toBe(240);
  });
});

describe('a link', () => {
  it('says all that it is told and reads it back', () => {
    const link = {
      step: 120,
      cell: { view: 1, organism: 0, id: 45 },
      colour: 'damage particle aggression',
      layers: ['cells', 'grid:a,b'],
      camera: { x: -1.5, y: 2.25, scale: 8 },
    };
    expect(parseLink(formatLink({ ...link, layers: ['cells'] }))).toEqual({ ...link, layers: ['cells'] });
    expect(formatLink(link)).toContain('step=120&cell=1,0,45&colour=damage%20particle%20aggression');
  });

  it('can say that no layer is on', () => {
    expect(parseLink(formatLink({ layers: [] }))).toEqual({ layers: [] });
  });

  it('ignores what makes no sense', () => {
    expect(parseLink('#step=-3&cell=1,2&view=a,b,c&other=1')).toEqual({});
    expect(parseLink('#cell=0,0,1.5&view=1,2,0')).toEqual({});
  });
});

describe('colours', () => {
  it('run from dark to light', () => {
    expect(scaleColour(0)).toBe('#440154');
    expect(scaleColour(1)).toBe('#fde725');
    expect(levelColour(2)).toBe(scaleColour(1));
    const lightness = [0, 0.25, 0.5, 0.75, 1].map((share) => {
      const [red, green, blue] = channels(scaleColour(share));
      return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    });
    expect(lightness).toEqual([...lightness].sort((a, b) => a - b));
  });

  it('show what is no number in grey', () => {
    expect(levelColour(NaN)).toBe('#9a9a9a');
  });

  it('return darker after six states', () => {
    expect(stateColour(6)).toBe(mix(stateColour(0), '#000000', 0.4));
  });
});

describe('paint', () => {
  const life = tinyLife();
  const names = (name: string) => life.stateNames.indexOf(name);
  const clones = new Clones(life, 11);

  it('is by state', () => {
    const paint = paintOf(life, 'state', clones, names, { low: 0, high: 1 }, 'light');
    expect([1, 2].map((row) => paint.colour(row))).toEqual([stateColour(0), stateColour(1)]);
    expect(paint.kinds.map(({ label }) => label)).toEqual(['root', 'leaf']);
  });

  it('is by a quantity, on a scale from 0', () => {
    const range = commonRange([life.attribute('energy'), undefined]);
    expect(range).toEqual({ low: 0, high: 1 });
    const paint = paintOf(life, 'energy', clones, names, range, 'light');
    expect(paint.colour(0)).toBe(scaleColour(1));
    expect(paint.colour(4)).toBe('#9a9a9a');
  });

  it('is by clone: descendants of the cells of a step', () => {
    expect(clones.count).toBe(2);
    expect([0, 1, 2].map((id) => clones.of({ organism: 0, id }))).toEqual([0, 1, 1]);
    expect(defaultCloneStep(life)).toBe(10);
  });
});

describe('contacts', () => {
  it('are the pairs that a comparison of all with all finds', () => {
    const count = 120;
    let seed = 1;
    const random = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
    const x = Float32Array.from({ length: count }, () => 16 * random() - 8);
    const y = Float32Array.from({ length: count }, () => 16 * random() - 8);
    const radius = Float32Array.from({ length: count }, () => 0.3 + random());
    const found: string[] = [];
    overlaps(x, y, radius, 10, count, (i, j) => found.push(`${Math.min(i, j)} ${Math.max(i, j)}`));
    const expected: string[] = [];
    for (let i = 10; i < count; ++i)
      for (let j = i + 1; j < count; ++j)
        if (Math.hypot(x[i] - x[j], y[i] - y[j]) < radius[i] + radius[j]) expected.push(`${i} ${j}`);
    expect(expected.length).toBeGreaterThan(50);
    expect(found.sort()).toEqual(expected.sort());
  });
});

describe('charts', () => {
  it('put lines of different lives on one axis', () => {
    const line = { label: 'a', colour: '#000000' };
    const { steps, columns } = alignLines([
      { ...line, first: 2, values: [5, 6] },
      { ...line, first: 3, values: [7, 8, 9] },
    ]);
    expect(steps).toEqual([2, 3, 4, 5]);
    expect(columns).toEqual([
      [5, 6, null, null],
      [null, 7, 8, 9],
    ]);
  });
});

describe('the extent of a life', () => {
  it('holds its cells', () => {
    expect(extentOf(tinyLife())).toEqual({ left: -1.5, right: 1.5, bottom: -1.5, top: 1.5 });
  });
});

describe('text', () => {
  it('has four digits', () => {
    expect([0, 0.123456, 1234.56, 12345678, 0.00001, NaN].map(number)).toEqual([
      '0', '0.1235', '1235', '1.23e+7', '1.00e-5', 'none',
    ]);
    expect(plural(1, 'cell') + plural(2, 'cell')).toBe('1 cell2 cells');
    expect(words('refused_division')).toBe('refused division');
  });

  it('of a step is CSV with exact numbers', () => {
    expect(cellCsv(tinyLife(), 2).split('\n').slice(0, 2)).toEqual([
      'organism,cell,mother,born,state,action,x,y,radius,energy',
      '0,1,0,11,leaf,quiescence,1.625,0,1,0.125',
    ]);
  });
});
