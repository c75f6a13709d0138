// A scene as these tests hold it: the values of an INRIA .ply in float64, in its frame. Written a
// second time on purpose, in another language than the code under test.
//
//   position, scale (logarithms), dc  3 numbers a splat
//   rotation                          4 (w, x, y, z)
//   opacity                           1 (logit)
//   rest                              3·K, channel-major, K coefficients of degrees 1…degree

export const restCount = (degree) => (degree + 1) ** 2 - 1;

/** The parts of a cloud and how many numbers each has for a splat. */
export const widths = (degree) => ({
  position: 3, scale: 3, rotation: 4, opacity: 1, dc: 3, rest: 3 * restCount(degree),
});

export function makeCloud(count, degree) {
  const cloud = {count, degree};
  for (const [part, width] of Object.entries(widths(degree))) {
    cloud[part] = new Float64Array(count * width);
  }
  return cloud;
}

export const sigmoid = (logit) => 1 / (1 + Math.exp(-logit));

/** A unit quaternion in `out`; a zero one becomes the identity. */
export function unitRotation(rotation, i, out) {
  // Scaled first: the squares of very small or large components leave the range of float64
  let largest = 0;
  for (let c = 0; c < 4; ++c) largest = Math.max(largest, Math.abs(rotation[4 * i + c]));
  if (largest === 0) return out.fill(0).fill(1, 0, 1);
  let sum = 0;
  for (let c = 0; c < 4; ++c) sum += (out[c] = rotation[4 * i + c] / largest) ** 2;
  for (let c = 0; c < 4; ++c) out[c] /= Math.sqrt(sum);
  return out;
}

/** Degrees of the turn between two unit quaternions, which are the same up to their sign. */
function degreesBetween(a, b) {
  let minus = 0, plus = 0;
  for (let c = 0; c < 4; ++c) {
    minus += (a[c] - b[c]) ** 2;
    plus += (a[c] + b[c]) ** 2;
  }
  return 4 * Math.asin(Math.min(1, Math.sqrt(Math.min(minus, plus)) / 2)) * 180 / Math.PI;
}

/** Limits a value to [low, high]. */
export const limited = (value, [low, high]) => Math.min(Math.max(value, low), high);

/** The splats of a cloud in another order: splat i is the one that was order[i]. */
export function reordered(cloud, order) {
  const result = makeCloud(cloud.count, cloud.degree);
  for (const [part, width] of Object.entries(widths(cloud.degree))) {
    order.forEach((from, i) => {
      for (let c = 0; c < width; ++c) result[part][width * i + c] = cloud[part][width * from + c];
    });
  }
  return result;
}

/** Keeps the largest difference; one that is no number counts as infinite. */
const larger = (worst, difference) =>
  Number.isNaN(difference) ? Infinity : Math.max(worst, difference);

function worstValue(a, b, measure) {
  let worst = 0;
  for (let i = 0; i < a.length; ++i) {
    if (a[i] !== b[i]) worst = larger(worst, measure(a[i], b[i], i));
  }
  return worst;
}

function worstRotation(a, b, count) {
  let worst = 0;
  const p = new Float64Array(4), q = new Float64Array(4);
  for (let i = 0; i < count; ++i) {
    worst = larger(worst, degreesBetween(unitRotation(a, i, p), unitRotation(b, i, q)));
  }
  return worst;
}

/** Degrees 1…degree of a cloud, channel-major, cut to fewer bands. */
function restOfDegree(cloud, degree) {
  const have = restCount(cloud.degree), want = restCount(degree);
  if (have === want) return cloud.rest;
  const cut = new Float64Array(cloud.count * 3 * want);
  for (let row = 0; row < 3 * cloud.count; ++row) {
    for (let k = 0; k < want; ++k) cut[row * want + k] = cloud.rest[row * have + k];
  }
  return cut;
}

const absolute = (from, to) => Math.abs(from - to);
const ofOpacities = (from, to) => Math.abs(sigmoid(from) - sigmoid(to));

/** The difference from a value that a format limits to a range. */
export const within = (range) => (from, to) => Math.abs(limited(from, range) - to);

/**
 * The worst difference of each attribute, splat by splat in the order of both: position (scene
 * units), scale (logarithm), rotation (degrees, sign-free), opacity (0…1), sh_dc, sh_rest.
 * `measures` holds what a format counts otherwise: functions of two different numbers, of `a` and of
 * `b`, and their index. Null if counts or degrees differ; `a` may have more bands where
 * `fewerBands` is set.
 */
export function worstDifferences(a, b, {measures = {}, fewerBands = false} = {}) {
  if (a.count !== b.count) return null;
  if (fewerBands ? a.degree < b.degree : a.degree !== b.degree) return null;
  const result = {
    position: worstValue(a.position, b.position, measures.position ?? absolute),
    scale: worstValue(a.scale, b.scale, measures.scale ?? absolute),
    rotation: worstRotation(a.rotation, b.rotation, a.count),
    opacity: worstValue(a.opacity, b.opacity, ofOpacities),
    sh_dc: worstValue(a.dc, b.dc, measures.sh_dc ?? absolute),
  };
  if (b.degree > 0) {
    const rest = restOfDegree(a, b.degree);
    result.sh_rest = worstValue(rest, b.rest, measures.sh_rest ?? absolute);
  }
  return result;
}
