// Formats whose steps differ from splat to splat. What they hold in such steps is measured as a part
// of the error that is allowed there: 1 is all of it.
import {limited, widths, within} from './cloud.mjs';
import {nodeScalesOfGlb} from './glb.mjs';
import {
  degreesOf, floatRotation, floatScale, floatScales, largest, opacityOf, rounding, shC0,
  smallestThree,
} from './rounding.mjs';
import {readSogMeta} from './sog.mjs';

const everything = [-Infinity, Infinity];
const chunkSplats = 256;

/** How far the values of a coordinate c of some splats of a part reach, once limited to a range. */
function extent(part, first, last, c, range) {
  let low = Infinity, high = -Infinity;
  for (let i = first; i < last; ++i) {
    const value = limited(part[3 * i + c], range);
    low = Math.min(low, value), high = Math.max(high, value);
  }
  return high - low;
}

/** Half a step for each coordinate and chunk, and `more`: so many bits divide the chunk's extent. */
function ofChunks(cloud, part, bits, more, range = everything) {
  const allowed = [];
  for (let first = 0; first < cloud.count; first += chunkSplats) {
    const last = Math.min(first + chunkSplats, cloud.count);
    bits.forEach((count, c) => {
      allowed.push(extent(cloud[part], first, last, c, range) / (2 ** count - 1) / 2 + more);
    });
  }
  return (from, to, i) => {
    const chunk = Math.floor(i / (3 * chunkSplats));
    return within(range)(from, to) / allowed[3 * chunk + i % 3];
  };
}

/**
 * Compressed .ply: chunks of 256 splats in the order of the file. Logarithms of scales are limited
 * to ±20. Rotations have three components of 10 bits from −√½ to √½, SH coefficients 256 steps from
 * −4 to 4, whose middles they take (of the first and last the ends). `cloud` has the file's order.
 */
export function compressedPly(cloud) {
  const few = 4;
  return {
    allowed: {
      position: 1, scale: 1, rotation: smallestThree(0.5 * Math.SQRT2 / 1023),
      opacity: opacityOf(8), sh_dc: 1, sh_rest: 0.5 * 8 / 256,
    },
    measures: {
      position: ofChunks(cloud, 'position', [11, 10, 11], few * rounding(largest(cloud.position))),
      scale: ofChunks(cloud, 'scale', [11, 10, 11], few * rounding(20), [-20, 20]),
      sh_dc: ofChunks(cloud, 'dc', [8, 8, 8], few * rounding(1 + largest(cloud.dc)) / shC0),
      sh_rest: within([-4, 4]),
    },
  };
}

const contracted = (value) => Math.sign(value) * Math.log1p(Math.abs(value));

/** Half of the 65,535 steps of each coordinate's contracted extent. */
function ofContracted(position) {
  const part = position.map(contracted), few = 4;
  const allowed = [0, 1, 2].map((c) =>
    extent(part, 0, part.length / 3, c, everything) / 65535 / 2 + few * rounding(1));
  return (from, to, i) => Math.abs(contracted(from) - contracted(to)) / allowed[i % 3];
}

/** The distance of the value that is nearest; `sorted` ascends. */
function nearestDistance(sorted, value) {
  let low = 0, high = sorted.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle; else high = middle;
  }
  return Math.min(Math.abs(value - sorted[low]), Math.abs(value - sorted[high]));
}

/** Each value takes the nearest of a codebook. */
function ofCodebook({codebook}) {
  const sorted = Float32Array.from(codebook).sort(), few = 4;
  const more = few * rounding(largest(sorted));
  return (from, to) => Math.abs(from - to) / (nearestDistance(sorted, from) + more);
}

/** How many different SH coefficients the splats have. */
function countDifferent({count, degree, rest}) {
  const width = widths(degree).rest;
  return new Set(Array.from({length: count}, (_, i) =>
    rest.subarray(width * i, width * (i + 1)).join())).size;
}

/**
 * SOG: 16 bits of positions, contracted; rotations with three components of 8 bits from −√½ to √½;
 * codebooks of 256 scales, colours and SH coefficients, of which a value takes the nearest. The SH
 * palette is exact where it has an entry for all that are different. Elsewhere entries are means of
 * what several splats have: of each coefficient no farther than its values reach.
 */
export function sog(cloud, file) {
  const meta = readSogMeta(file), exact = meta.shN && countDifferent(cloud) <= meta.shN.count;
  return {
    allowed: {
      position: 1, scale: 1, rotation: smallestThree(0.5 * Math.SQRT2 / 255),
      opacity: opacityOf(8), sh_dc: 1, sh_rest: exact ? 1 : 2 * largest(cloud.rest),
    },
    measures: {
      position: ofContracted(cloud.position), scale: ofCodebook(meta.scales),
      sh_dc: ofCodebook(meta.sh0), sh_rest: exact ? ofCodebook(meta.shN) : undefined,
    },
  };
}

/**
 * Plain .glb with integers of so many bits: rotations from −1 to 1, opacities, and scales as parts of
 * their node's, none of them 0. Positions and SH coefficients are floats; our reader turns the latter
 * with their node, in float64, though it only scales.
 */
export const quantizedGlb = (bits) => async (cloud, file) => {
  const nodes = await nodeScalesOfGlb(file), most = 2 ** bits - 1;
  const halfStep = 0.5 / most + floatScale(cloud);
  const ofNode = (scale, i) => Math.exp(limited(scale, floatScales)) / nodes[Math.floor(i / 3)];
  return {
    allowed: {
      position: 0, scale: 1, rotation: degreesOf(2 * 0.5 / (2 ** (bits - 1) - 1)) + floatRotation,
      opacity: opacityOf(bits), sh_dc: 0, sh_rest: 2 ** -49 * largest(cloud.rest),
    },
    measures: {
      scale: (from, to, i) =>
        Math.abs(limited(ofNode(from, i), [1 / most, 1]) - ofNode(to, i)) / halfStep,
    },
  };
};
