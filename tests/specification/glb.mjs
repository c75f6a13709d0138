// Reads a .glb with KHR_gaussian_splatting through glTF-Transform, which does not know the
// extension: what it sees are accessors and nodes, checked as for any glTF.
import {makeCloud, restCount} from './cloud.mjs';
import {load} from './programs.mjs';
import {largest} from './rounding.mjs';

const {Extension, Logger, NodeIO} = await load('@gltf-transform/core');

const prefix = 'KHR_gaussian_splatting:';

/** Makes glTF-Transform open a file that requires the extension, and keep what primitives say. */
class GaussianSplatting extends Extension {
  static EXTENSION_NAME = 'KHR_gaussian_splatting';
  extensionName = GaussianSplatting.EXTENSION_NAME;

  read({jsonDoc: {json}}) {
    this.kept = json.meshes?.[0].primitives[0].extensions;
    return this;
  }

  write({jsonDoc: {json}}) {
    for (const {primitives} of json.meshes ?? []) {
      for (const primitive of primitives) primitive.extensions = this.kept;
    }
    return this;
  }
}

const io = new NodeIO()
  .setLogger(new Logger(Logger.Verbosity.SILENT))
  .registerExtensions([GaussianSplatting]);

/** Orders m of the basis functions from degree 1, in the order of their coefficients. */
const orders = [1, 2, 3].flatMap((l) => Array.from({length: 2 * l + 1}, (_, i) => i - l));

/** Primitives that the default scene shows, with their nodes' scales; nothing else may move them. */
function splatPrimitives(document) {
  const primitives = [];
  const scene = document.getRoot().getDefaultScene();
  if (!scene) throw new Error('no default scene');
  scene.traverse((node) => {
    const matrix = node.getWorldMatrix(), scale = matrix[0];
    if (matrix.some((value, i) => value !== (i === 15 ? 1 : i % 5 === 0 ? scale : 0))) {
      throw new Error('a node has a transform that is no even scale');
    }
    for (const primitive of node.getMesh()?.listPrimitives() ?? []) {
      primitives.push({primitive, scale});
    }
  });
  return primitives;
}

function rowsOf(primitive, semantic, width) {
  const accessor = primitive.getAttribute(semantic);
  if (!accessor) throw new Error(`no attribute ${semantic}`);
  if (accessor.getElementSize() !== width) throw new Error(`${semantic}: wrong type`);
  const row = [];
  return {count: accessor.getCount(), at: (i) => accessor.getElement(i, row)};
}

function degreeOf(primitive) {
  let degree = 0;
  while (primitive.getAttribute(`${prefix}SH_DEGREE_${degree + 1}_COEF_0`)) ++degree;
  return degree;
}

/** Numbers i of a splat's part, in its place: splats of a primitive begin at `first`. */
const put = (part, width, first) => (i, values) => part.set(values, width * (first + i));

/**
 * Half a turn about z from glTF's frame (y up) into that of a .ply (y down): positions change the
 * sign of x and y, a quaternion q becomes (0, 0, 0, 1)·q, a basis function of order m takes (−1)^m.
 * glTF stores scale and opacity, a .ply their logarithm and logit, both quaternions' w elsewhere.
 * A scale of 0, which has no logarithm, becomes the least normal float. Bands that the primitive lacks
 * stay 0.
 */
function fillCloud(cloud, primitive, nodeScale, first) {
  const named = (name, width) => rowsOf(primitive, prefix + name, width);
  const position = rowsOf(primitive, 'POSITION', 3), scale = named('SCALE', 3);
  const rotation = named('ROTATION', 4), opacity = named('OPACITY', 1);
  const dc = named('SH_DEGREE_0_COEF_0', 3);
  const putPosition = put(cloud.position, 3, first), putScale = put(cloud.scale, 3, first);
  const putRotation = put(cloud.rotation, 4, first), putDc = put(cloud.dc, 3, first);
  for (let i = 0; i < position.count; ++i) {
    const [x, y, z] = position.at(i);
    putPosition(i, [-x, -y, z].map((value) => value * nodeScale));
    putScale(i, scale.at(i).map((value) => Math.log((value || 2 ** -126) * nodeScale)));
    const [qx, qy, qz, qw] = rotation.at(i);
    putRotation(i, [-qz, -qy, qx, qw]);
    const [o] = opacity.at(i);
    cloud.opacity[first + i] = Math.log(o) - Math.log1p(-o);
    putDc(i, dc.at(i));
  }
  const count = restCount(degreeOf(primitive)), stride = restCount(cloud.degree);
  for (let k = 0, l = 1, m = 0; k < count; ++k) {
    const sign = orders[k] % 2 === 0 ? 1 : -1;
    const coefficient = named(`SH_DEGREE_${l}_COEF_${m}`, 3);
    for (let i = 0; i < position.count; ++i) {
      const row = coefficient.at(i);
      for (let c = 0; c < 3; ++c) cloud.rest[(3 * (first + i) + c) * stride + k] = sign * row[c];
    }
    if (++m === 2 * l + 1) m = 0, ++l;
  }
}

const countOf = (primitive) => primitive.getAttribute('POSITION')?.getCount() ?? 0;

/** The splats of a .glb, those of one primitive after those of another. */
export async function readGlb(file) {
  const primitives = splatPrimitives(await io.read(file));
  if (primitives.length === 0) throw new Error('no primitives; expected one at least');
  const count = primitives.reduce((sum, {primitive}) => sum + countOf(primitive), 0);
  const cloud = makeCloud(count, Math.max(...primitives.map(({primitive}) => degreeOf(primitive))));
  let first = 0;
  for (const {primitive, scale} of primitives) {
    fillCloud(cloud, primitive, scale, first);
    first += countOf(primitive);
  }
  return cloud;
}

/** The scale of the node of each splat of a .glb. */
export async function nodeScalesOfGlb(file) {
  const primitives = splatPrimitives(await io.read(file));
  return primitives.flatMap(({primitive, scale}) => new Array(countOf(primitive)).fill(scale));
}

/** How many splats glTF-Transform finds in a .glb that may be empty. */
export async function countGlb(file) {
  const primitives = splatPrimitives(await io.read(file));
  return primitives.reduce((sum, {primitive}) => sum + countOf(primitive), 0);
}

/** Turns the numbers of an attribute into integers of a type that stand for −1 or 0 to 1. */
function quantizeAttribute(primitive, name, Type, factor = 1) {
  const accessor = primitive.getAttribute(prefix + name), count = accessor.getCount();
  const rows = Array.from({length: count}, (_, i) =>
    accessor.getElement(i, []).map((value) => value * factor));
  accessor.setArray(new Type(count * accessor.getElementSize())).setNormalized(true);
  rows.forEach((row, i) => accessor.setElement(i, row));
}

/**
 * Lets glTF-Transform store rotations, scales and opacities of a plain .glb in so many bits. The node
 * gets the largest scale, and positions are divided by it.
 */
export async function quantizeGlb(from, to, bits) {
  const [Signed, Unsigned] = bits === 8 ? [Int8Array, Uint8Array] : [Int16Array, Uint16Array];
  const document = await io.read(from);
  const node = document.getRoot().listNodes().find((one) => one.getMesh());
  const [primitive] = node.getMesh().listPrimitives();
  const most = largest(primitive.getAttribute(`${prefix}SCALE`).getArray());
  node.setScale([most, most, most]);
  quantizeAttribute(primitive, 'ROTATION', Signed);
  quantizeAttribute(primitive, 'SCALE', Unsigned, 1 / most);
  quantizeAttribute(primitive, 'OPACITY', Unsigned);
  const position = primitive.getAttribute('POSITION');
  position.setArray(position.getArray().map((value) => value / most));
  await io.write(to, document);
}
