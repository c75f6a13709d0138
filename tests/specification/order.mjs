// The order in which a format stores the splats of a scene. It depends on positions and scales alone;
// a second scene with the same, whose colours are three digits of each splat's number, tells it.
import {widths} from './cloud.mjs';

const digits = 64;

/** Colours that every format keeps apart, about 0. */
const colourOf = (digit) => (digit - (digits - 1) / 2) / 20;
const digitOf = (colour) => Math.round(20 * colour + (digits - 1) / 2);

/** A scene with the positions and scales of `cloud`, whose colours number its splats. */
export function numbered(cloud) {
  if (cloud.count > digits ** 3) throw new Error(`cannot number ${cloud.count} splats`);
  const dc = new Float64Array(widths(0).dc * cloud.count);
  for (let i = 0; i < cloud.count; ++i) {
    for (let c = 0; c < 3; ++c) dc[3 * i + c] = colourOf(Math.floor(i / digits ** c) % digits);
  }
  return {...cloud, degree: 0, dc, rest: new Float64Array(0)};
}

/** For each splat of a reading of that scene its number, of which each must be there once. */
export function numbersOf(reading) {
  const order = new Uint32Array(reading.count), seen = new Set();
  for (let i = 0; i < reading.count; ++i) {
    for (let c = 0; c < 3; ++c) order[i] += digitOf(reading.dc[3 * i + c]) * digits ** c;
    seen.add(order[i]);
  }
  if (seen.size !== reading.count || order.some((number) => number >= reading.count)) {
    throw new Error('splats are missing, or there more than once');
  }
  return order;
}
