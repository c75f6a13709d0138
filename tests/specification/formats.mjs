// What the quantization of each format that we write allows: the largest error of each attribute,
// and how it is measured, as within a range. Half a step, and the rounding of floats on the way.
import {readFileSync} from 'node:fs';
import {gunzipSync} from 'node:zlib';

import {within} from './cloud.mjs';
import {compressedPly, quantizedGlb, sog} from './ranges.mjs';
import {
  degreesOf, floatRotation, floatScale, floatScales, largest, opacityOf, rounding, shC0,
  smallestThree,
} from './rounding.mjs';

/**
 * glTF: floats. Positions and SH coefficients change at most their signs; opacity and scale are stored
 * themselves, rotations as unit quaternions.
 */
const glb = (cloud) => ({
  allowed: {
    position: 0, scale: floatScale(cloud), rotation: floatRotation, opacity: rounding(1),
    sh_dc: 0, sh_rest: 0,
  },
  measures: {scale: within(floatScales)},
});

/**
 * .splat: position and scale are floats, colours and opacity have 256 levels, the components of the
 * quaternion steps of 1/128 (a component of 1, for which there is no level, errs by a whole step,
 * but along the quaternion, which turns nothing).
 */
const splat = (cloud) => ({
  allowed: {
    position: 0, scale: floatScale(cloud), rotation: degreesOf(Math.sqrt(4) / 256),
    opacity: opacityOf(8), sh_dc: 0.5 / 255 / shC0 + rounding(2),
  },
  measures: {scale: within(floatScales), sh_dc: within([-0.5 / shC0, 0.5 / shC0])},
});

/** Bits behind the point of the positions of an SPZ file; version 4 is not compressed as a whole. */
function fractionalBits(file) {
  const bytes = readFileSync(file);
  return (bytes.toString('latin1', 0, 4) === 'NGSP' ? bytes : gunzipSync(bytes))[13];
}

/**
 * SPZ (README of nianticlabs/spz): 24-bit positions, logarithms of scales in steps of 1/16 from
 * −10, colours in steps of 1/38.25, SH coefficients in steps of 1/16 (degree 1) and 1/8 (5 and 4 of 8
 * bits), three components of the rotations in steps of 1/(511·√2).
 */
const spz = (cloud, file) => ({
  allowed: {
    position: 2 ** -(fractionalBits(file) + 1), scale: 1 / 32,
    rotation: smallestThree(0.5 / (511 * Math.SQRT2)), opacity: opacityOf(8),
    sh_dc: 0.5 / 38.25 + rounding(4), sh_rest: cloud.degree > 1 ? 1 / 16 : 1 / 32,
  },
  measures: {
    scale: within([-10, 5.9375]), sh_dc: within([-0.5 / 0.15, 0.5 / 0.15]),
    sh_rest: within([-1, 127 / 128]),
  },
});

/** .ply: the floats themselves. */
const ply = () => ({
  allowed: {position: 0, scale: 0, rotation: 0, opacity: 0, sh_dc: 0, sh_rest: 0},
});

/**
 * The formats that `fluxgs convert` writes with exact, stated quantization, and the options for it.
 * `quantization` takes the scene in the order of the file, which differs where it `reorders`.
 */
export const writtenFormats = [
  {extension: '.ply', maxDegree: 3, quantization: ply},
  {extension: '.compressed.ply', maxDegree: 3, reorders: true, quantization: compressedPly},
  {extension: '.glb', maxDegree: 3, quantization: glb},
  ...[8, 16].map((bits) => ({
    extension: `.${bits}-bit.glb`, options: ['--quantize-attributes', String(bits)], maxDegree: 3,
    reorders: true, quantization: quantizedGlb(bits),
  })),
  {extension: '.spz', maxDegree: 3, quantization: spz},
  {extension: '.v4.spz', options: ['--spz-version', '4'], maxDegree: 3, quantization: spz},
  {extension: '.sog', maxDegree: 3, reorders: true, quantization: sog},
  {extension: '.splat', maxDegree: 0, quantization: splat},
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
