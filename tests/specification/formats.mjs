// What the quantization of each format that we write allows: the largest error of each attribute,
// and the range that values are limited to. Half a step, and the rounding of floats on the way.
import {readFileSync} from 'node:fs';
import {gunzipSync} from 'node:zlib';

const shC0 = 0.28209479177387814;  // the constant basis function, 1/(2√π)

/** Rounding of a float of this size to the nearest: half a unit in the last place. */
const rounding = (size) => size * 2 ** -24;

const largest = (values) => values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);

/** Degrees of the turn between unit quaternions that are this far apart. */
const degreesOf = (distance) => 4 * Math.asin(Math.min(1, distance / 2)) * 180 / Math.PI;

/** Four components, each less than 1, rounded to floats. */
const floatRotation = degreesOf(2 * rounding(0.5));

/** A logarithm, rounded, of a scale that is rounded: the latter errs relative to itself. */
const floatScale = (cloud) => rounding(1) + rounding(largest(cloud.scale));

/** Logarithms of what a float can hold without losing digits. */
const floatScales = [Math.log(2 ** -126), Math.log((2 - 2 ** -23) * 2 ** 127)];

/**
 * glTF: floats. Positions and SH coefficients change at most their signs; opacity and scale are stored
 * themselves, rotations as unit quaternions.
 */
const glb = (cloud) => ({
  allowed: {
    position: 0, scale: floatScale(cloud), rotation: floatRotation, opacity: rounding(1),
    sh_dc: 0, sh_rest: 0,
  },
  ranges: {scale: floatScales},
});

/**
 * .splat: position and scale are floats, colours and opacity have 256 levels, the components of the
 * quaternion steps of 1/128 (a component of 1, for which there is no level, errs by a whole step,
 * but along the quaternion, which turns nothing).
 */
const splat = (cloud) => ({
  allowed: {
    position: 0, scale: floatScale(cloud), rotation: degreesOf(Math.sqrt(4) / 256),
    opacity: 0.5 / 255 + rounding(1), sh_dc: 0.5 / 255 / shC0 + rounding(2),
  },
  ranges: {scale: floatScales, sh_dc: [-0.5 / shC0, 0.5 / shC0]},
});

/** Bits behind the point of the positions of an SPZ file, versions 1 to 3. */
const fractionalBits = (file) => gunzipSync(readFileSync(file))[13];

/**
 * SPZ (README of nianticlabs/spz): 24-bit positions, logarithms of scales in steps of 1/16 from
 * −10, colours in steps of 1/38.25, SH coefficients in steps of 1/16 (degree 1) and 1/8 (5 and 4 of 8
 * bits). Of the quaternion the three smallest components have steps of 1/(511·√2); the fourth
 * follows, and errs at worst, where it is 1/2, by three of their half steps.
 */
const spz = (cloud, file) => ({
  allowed: {
    position: 2 ** -(fractionalBits(file) + 1), scale: 1 / 32,
    rotation: degreesOf(0.5 / (511 * Math.SQRT2) * Math.sqrt(3 + 9)) + floatRotation,
    opacity: 0.5 / 255 + rounding(1), sh_dc: 0.5 / 38.25 + rounding(4),
    sh_rest: cloud.degree > 1 ? 1 / 16 : 1 / 32,
  },
  ranges: {scale: [-10, 5.9375], sh_dc: [-0.5 / 0.15, 0.5 / 0.15], sh_rest: [-1, 127 / 128]},
});

/** .ply: the floats themselves. */
const ply = () => ({
  allowed: {position: 0, scale: 0, rotation: 0, opacity: 0, sh_dc: 0, sh_rest: 0}, ranges: {},
});

/** The formats that `fluxgs convert` writes with exact, stated quantization; all keep the order. */
export const writtenFormats = [
  {name: 'ply', extension: '.ply', maxDegree: 3, quantization: ply},
  {name: 'glb', extension: '.glb', maxDegree: 3, quantization: glb},
  {name: 'spz', extension: '.spz', maxDegree: 3, quantization: spz},
  {name: 'splat', extension: '.splat', maxDegree: 0, quantization: splat},
];

/** splat-transform limits opacities to 10⁻⁶ … 1 − 10⁻⁶ where it decodes 8 bits. */
const opacityLimit = 1e-6;

/**
 * How far two programs may differ that decode the same bytes: by the rounding of a few float
 * operations. `cloud` tells the size of the numbers.
 */
export function decodingTolerance(cloud) {
  const few = 8;
  return {
    position: few * rounding(largest(cloud.position)),
    scale: few * rounding(1 + largest(cloud.scale)),
    rotation: few * floatRotation,
    opacity: opacityLimit + few * rounding(1),
    sh_dc: few * rounding(1 + largest(cloud.dc)),
    sh_rest: few * rounding(1 + largest(cloud.rest)),
  };
}

/**
 * splat-transform takes a byte b of a .splat's quaternion for b/127.5 − 1; antimatter15's viewer,
 * whose format it is, and fluxgs take it for b/128 − 1. That moves the components c by (c + 1)/255,
 * of which the part along c turns nothing.
 */
export const splatLevelTurn = degreesOf(Math.sqrt(4) / 255);

/** Our reading of a .splat with the levels of its rotations taken as splat-transform takes them. */
export const withOtherSplatLevels = (cloud) => ({
  ...cloud, rotation: cloud.rotation.map((c) => Math.round((c + 1) * 128) / 127.5 - 1),
});
