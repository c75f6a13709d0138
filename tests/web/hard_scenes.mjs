// Scenes that break renderers: a few kinds of those of tests/unit/renderer/hard_cases_test.cpp.
import {gunzipSync, gzipSync} from 'node:zlib';

/** Numbers of 0…1 that are the same in every run. */
function randomOf(seed) {
  return () => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return seed / 2 ** 32;
  };
}

const REST = 45;  // coefficients of degrees 1…3
const PROPERTIES = ['x', 'y', 'z', 'f_dc_0', 'f_dc_1', 'f_dc_2', ...Array.from({length: REST}, (_, i) => `f_rest_${i}`), 'opacity',
  'scale_0', 'scale_1', 'scale_2', 'rot_0', 'rot_1', 'rot_2', 'rot_3'];

/** Splats: {position, scale (log), rotation, opacity (logit), color (coefficient), rest}. */
function ply(splats) {
  const head = `ply\nformat binary_little_endian 1.0\nelement vertex ${splats.length}\n${PROPERTIES.map((name) => `property float ${name}\n`).join('')}end_header\n`;
  const rows = Float32Array.from(splats.flatMap(({position, color, rest = new Array(REST).fill(0), opacity, scale, rotation}) =>
    [...position, ...color, ...rest, opacity, ...scale, ...rotation]));
  return Buffer.concat([Buffer.from(head), Buffer.from(rows.buffer)]);
}

function cloud(count, seed, change = (splat) => splat) {
  const random = randomOf(seed), about = (width) => (random() - 0.5) * 2 * width;
  return Array.from({length: count}, (_, i) => change({
    position: [about(1), about(1), about(1)],
    scale: [-3 + about(1), -3 + about(1), -3 + about(1)],
    rotation: [about(1), about(1), about(1), about(1)],
    opacity: about(4),
    color: [about(1.5), about(1.5), about(1.5)],
    rest: Array.from({length: REST}, () => about(0.3)),
  }, i, random));
}

/** A .spz file (version 3) as one whose screen filter compensates opacities. */
function antialiased(spz) {
  const bytes = gunzipSync(spz), flags = 14;
  bytes[flags] |= 1;
  return gzipSync(bytes);
}

/** Files by their names; one of them is made from a .spz. */
export function hardScenes(spz) {
  const needles = cloud(600, 11, (s, i) => ({...s, scale: i % 2 ? [-1, -14, -14] : [-1, -14, -1]}));
  const far = cloud(800, 12, (s) => ({...s, position: s.position.map((x) => 4096 + x)}));
  const layers = cloud(3000, 13, (s, i, random) => ({...s, position: [0, 0, i % 16 * 1e-3], scale: [-0.5, -0.5, -6], rotation: [1, 0, 0, 0],
    opacity: -4 + random()}));
  const giants = cloud(300, 14, (s, i) => (i % 30 ? s : {...s, position: s.position.map((x) => 8 * x), scale: [5, 5, 2], opacity: -1}));
  const strange = cloud(500, 15, (s, i) => [s, {...s, rotation: [0, 0, 0, 0]}, {...s, rotation: s.rotation.map((x) => 1e18 * x)},
    {...s, position: [NaN, 0, 0]}, {...s, scale: [-60, -60, -60]}, {...s, opacity: 80}, {...s, opacity: -80}][i % 7]);
  const one = [{position: [0, 0, 0], scale: [-1, -2, -1.5], rotation: [1, 0.3, 0, 0], opacity: 3, color: [1, 0, -1]}];
  const equal = cloud(700, 16, (s) => ({...s, position: [s.position[0], s.position[1], 0]}));
  const clouds = {needles, far, layers, giants, strange, one, equal};
  return {...Object.fromEntries(Object.entries(clouds).map(([name, splats]) => [`${name}.ply`, ply(splats)])), 'antialiased.spz': antialiased(spz)};
}
