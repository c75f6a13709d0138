// Scenes from code: the same numbers on every machine.
import {makeCloud, restCount, unitRotation} from './cloud.mjs';

/** Uniform numbers in [0, 1): the generator mulberry32. */
function randomNumbers(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** Standard normal numbers (Box and Muller 1958). */
function normalNumbers(seed) {
  const uniform = randomNumbers(seed);
  return () => Math.sqrt(-2 * Math.log(1 - uniform())) * Math.cos(2 * Math.PI * uniform());
}

/** Fills a part from a function of the index, rounded to the floats that a .ply holds. */
const fill = (part, value) => {
  for (let i = 0; i < part.length; ++i) part[i] = Math.fround(value(i));
};

/** A cloud as training leaves it, within the ranges that every format holds. */
export function randomScene(count, degree, seed = 1) {
  const uniform = randomNumbers(seed), normal = normalNumbers(seed + 1000);
  const within = (value, most) => Math.min(Math.max(value, -most), most);
  const cloud = makeCloud(count, degree);
  fill(cloud.position, () => 20 * (uniform() - 0.5));
  fill(cloud.scale, () => within(-4 + 1.2 * normal(), 9));
  fill(cloud.rotation, normal);
  fill(cloud.opacity, () => 2 * normal());
  fill(cloud.dc, () => within(0.8 * normal(), 1.75));
  fill(cloud.rest, () => within(0.15 * normal(), 0.9));
  return cloud;
}

/** The same with splats of all degrees in turn, whose higher bands are zeros. */
export function mixedScene(count, seed) {
  const cloud = randomScene(count, 3, seed), bands = restCount(3);
  for (let i = 0; i < count; ++i) {
    for (let c = 0; c < 3; ++c) {
      const first = (3 * i + c) * bands;
      cloud.rest.fill(0, first + restCount(i % 4), first + bands);
    }
  }
  return cloud;
}

/** A random scene with quaternions of unit length, which splat-transform's .splat needs. */
export function unitScene(count, degree, seed) {
  const cloud = randomScene(count, degree, seed);
  const unit = new Float64Array(4);
  for (let i = 0; i < count; ++i) {
    cloud.rotation.set(unitRotation(cloud.rotation, i, unit).map(Math.fround), 4 * i);
  }
  return cloud;
}

const cycle = (values) => (i) => values[i % values.length];

/**
 * Values at and beyond the ends of what formats hold: far and near positions, needles and planes,
 * opacities of 0 and 1, colours outside of 0…1, quaternions along axes, with equal components,
 * negative, and of any length.
 */
export function extremeScene(degree) {
  const count = 210;
  const cloud = makeCloud(count, degree);
  fill(cloud.position, cycle([0, -0, 1e-6, -1e-6, 1500.25, -2000.5, 0.125]));
  fill(cloud.scale, cycle([-30, -12, -10, 0, 5.9375, 6, 12, 40, -60, -4.2]));
  const r = Math.SQRT1_2;
  const rotations = [
    [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [-1, 0, 0, 0], [0, 0, 0, -1],
    [0.5, 0.5, 0.5, 0.5], [0.5, -0.5, 0.5, -0.5], [r, r, 0, 0], [0, -r, 0, r],
    [1e-15, 2e-15, -3e-15, 1e-15], [1e15, 3e15, -2e15, 4e15], [0.999, 0.01, 0.02, 0.03],
  ];
  fill(cloud.rotation, (i) => rotations[(i >> 2) % rotations.length][i % 4]);
  fill(cloud.opacity, cycle([-60, -20, -5.5, 0, 5.5, 20, 60]));
  fill(cloud.dc, cycle([-12, -3.4, -1.8, 0, 1.8, 3.4, 12]));
  fill(cloud.rest, cycle([-5, -1, -0.97, -0.5, 0, 0.03, 0.5, 0.97, 1, 5, 0.0625]));
  return cloud;
}
