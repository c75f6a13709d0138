// Sizes of errors: of floats, and of numbers that are stored in steps.

/** Rounding of a float of this size to the nearest: half a unit in the last place. */
export const rounding = (size) => size * 2 ** -24;

export const largest = (values) =>
  values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);

/** Degrees of the turn between unit quaternions that are this far apart. */
export const degreesOf = (distance) => 4 * Math.asin(Math.min(1, distance / 2)) * 180 / Math.PI;

/** Four components, each less than 1, rounded to floats. */
export const floatRotation = degreesOf(2 * rounding(0.5));

/**
 * Of a unit quaternion the three smallest components err by half a step each; the fourth follows.
 * The worst are components that are all 1/2, of which the three are rounded up.
 */
export function smallestThree(halfStep) {
  const fourth = Math.sqrt(1 - 3 * (0.5 + halfStep) ** 2);
  return degreesOf(Math.hypot(Math.sqrt(3) * halfStep, 0.5 - fourth)) + floatRotation;
}

/** Half a step of an opacity with so many bits. */
export const opacityOf = (bits) => 0.5 / (2 ** bits - 1) + rounding(1);

/** A logarithm, rounded, of a scale that is rounded: the latter errs relative to itself. */
export const floatScale = (cloud) => rounding(1) + rounding(largest(cloud.scale));

/** Logarithms of what a float can hold without losing digits. */
export const floatScales = [Math.log(2 ** -126), Math.log((2 - 2 ** -23) * 2 ** 127)];

export const shC0 = 0.28209479177387814;  // the constant basis function, 1/(2√π)
