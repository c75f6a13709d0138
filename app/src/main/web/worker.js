// A worker with its own instance of the module: it either reads one scene, or sorts the splats of those
// that are shown. The page puts flux.js before this text, and sends a compiled module first.
/* global fluxModule */
'use strict';

let module;

/** A copy of a part of the module's memory. */
const copy = (address, bytes) => module.HEAPU8.slice(address, address + bytes).buffer;

const withText = (text, use) => {
  const address = module.stringToNewUTF8(text);
  try {
    return use(address);
  } finally {
    module._free(address);
  }
};

/** An error with the name that LoadState::problem has for it. */
const failure = (problem, message) => Object.assign(new Error(message), {problem});

// ---- Reading

/** Answers with a scene as blocks, or with what of it has come. */
function post(whole) {
  const blocks = [];
  for (let i = 0; i < module._flux_block_count(); ++i)
    blocks.push(copy(module._flux_read_block(i), module._flux_read_block_bytes(i)));
  const head = copy(module._flux_read_head(), module._flux_head_bytes());
  const loading = JSON.parse(module.UTF8ToString(module._flux_read_state()));
  postMessage({scene: {head, blocks, loading, whole}}, [head, ...blocks]);
}

/** Decodes what has come of a file. */
function decode(name, come, memory, whole) {
  const read = withText(name, (address) => module._flux_read(address, come, memory));
  if (read) return post(whole);
  if (!whole) return;
  const {error, problem} = JSON.parse(module.UTF8ToString(module._flux_read_state()));
  throw failure(problem, error);
}

/** Makes room in the module for so many bytes of the file. */
function room(bytes, name) {
  const address = module._flux_reader_room(bytes);
  if (!address && bytes) throw failure('memory', `${name}: memory: no room for a file of ${bytes} bytes`);
  return address;
}

/** The response to a request, or an error that says what to do. */
async function request(url, name) {
  let answer;
  try {
    answer = await fetch(url);
  } catch (error) {
    throw failure('network', `${name}: cannot be fetched: no connection, or its server does not allow other pages ` +
      `to read it (it must send Access-Control-Allow-Origin)`);
  }
  if (!answer.ok) throw failure('network', `${name}: the server answered ${answer.status} ${answer.statusText}`);
  if ((answer.headers.get('content-type') ?? '').startsWith('text/html'))
    throw failure('network', `${name}: is a web page, not a scene; expected a link to the file itself`);
  return answer;
}

// A scene of several files is put into one that the module reads: those of SOG into an archive, those of glTF into its
// text. Their names come from a stranger: they must lie where the first one lies.

const MOST_JSON = 2 ** 24;  // bytes of a text that may name files
const MOST_FILES = 4096;

/** The object that a text of JSON is; undefined where it is none. */
function objectOf(bytes) {
  try {
    const value = JSON.parse(new TextDecoder().decode(bytes));
    return typeof value === 'object' && value ? value : undefined;
  } catch {
    return undefined;
  }
}

/** Finds files beside an address, or below: each as its announced bytes and what has an arrayBuffer(). */
const besideAddress = (base) => async (file, name) => {
  if (!/^https?:/.test(base)) throw failure('files', `${name}: ${file}: is not in it; expected an address of http or https`);
  const answer = await request(new URL(file.split('/').map(encodeURIComponent).join('/'), base).href, `${name}: ${file}`);
  return [Number(answer.headers.get('content-length')) || 0, answer];
};

/** The same among files that were chosen together. */
function amongFiles(files) {
  const chosen = new Map(files);
  return async (file, name) => {
    const found = chosen.get(file);
    if (!found) throw failure('files', `${name}: ${file}: was not chosen with it`);
    return [found.size, found];
  };
}

/** The files of these names: pairs of names and bytes, which together are no more than `memory`. */
async function findAll(files, find, name, memory) {
  if (files.length > MOST_FILES) throw failure('', `${name}: has ${files.length} files; at most ${MOST_FILES} are read`);
  let read = 0;
  const room = (bytes) => {
    if (read + bytes > memory) throw failure('memory', `${name}: memory: its files have more than the ${memory} bytes that may be used`);
  };
  return Promise.all(files.map(async (file) => {
    if (/[:\\]|^\/|(^|\/)\.\.(\/|$)/.test(file))
      throw failure('', `${name}: "${file.slice(0, 80)}" is not read; expected a file in the same folder`);
    const [announced, answer] = await find(file, name);
    room(announced);
    const bytes = new Uint8Array(await answer.arrayBuffer());
    room(bytes.length);
    postMessage({progress: {read: (read += bytes.length), bytes: 0}});
    return [file, bytes];
  }));
}

const CRCS = Uint32Array.from({length: 256}, (_, crc) => {
  for (let i = 0; i < 8; ++i) crc = crc >>> 1 ^ (crc & 1 && 0xedb88320);
  return crc;
});
function crc32(bytes) {
  let crc = ~0;
  for (const byte of bytes) crc = crc >>> 8 ^ CRCS[(crc ^ byte) & 255];
  return ~crc >>> 0;
}

/** A ZIP archive of files that are stored as they are (APPNOTE 4.3.7, 4.3.12, 4.3.16). */
function archiveOf(files) {
  const parts = [], directory = [];
  let at = 0;
  const numbers = (...sized) => {
    const bytes = new Uint8Array(sized.reduce((sum, [, size]) => sum + size, 0)), view = new DataView(bytes.buffer);
    let place = 0;
    for (const [value, size] of sized) {
      size === 4 ? view.setUint32(place, value, true) : view.setUint16(place, value, true);
      place += size;
    }
    return bytes;
  };
  for (const [file, bytes] of files) {
    const path = new TextEncoder().encode(file);
    // Version, flags (names are UTF-8), method, time, date, CRC, sizes, length of the name, of more
    const common = [[20, 2], [0x800, 2], [0, 2], [0, 2], [33, 2], [crc32(bytes), 4], [bytes.length, 4], [bytes.length, 4], [path.length, 2], [0, 2]];
    parts.push(numbers([0x04034b50, 4], ...common), path, bytes);
    directory.push(numbers([0x02014b50, 4], [20, 2], ...common, [0, 2], [0, 2], [0, 2], [0, 4], [at, 4]), path);
    at += 30 + path.length + bytes.length;
  }
  const size = directory.reduce((sum, part) => sum + part.length, 0);
  return new Blob([...parts, ...directory, numbers([0x06054b50, 4], [0, 2], [0, 2], [files.length, 2], [files.length, 2], [size, 4], [at, 4], [0, 2])]);
}

/** The name of the file that an address of glTF means. */
function fileOf(uri, name) {
  try {
    return decodeURIComponent(uri);
  } catch {
    throw failure('', `${name}: "${uri.slice(0, 80)}" is no address of a file`);
  }
}

const asData = (bytes) => new Promise((resolve) => {
  const reader = new FileReader();
  reader.onload = () => resolve(reader.result.replace(/^[^,]*/, 'data:application/octet-stream;base64'));
  reader.readAsDataURL(new Blob([bytes]));
});

/** The images that a meta.json of SOG names. */
const imagesOf = (meta) => [...new Set(Object.values(meta).flatMap((part) => part?.files ?? []).map(String))];

/** The names of the files with the finest level of a streamed SOG scene. */
function finestFiles({filenames, tree}) {
  const files = new Set();
  for (const nodes = [tree]; nodes.length;) {
    const {lods, children} = nodes.pop() ?? {};
    if (lods?.[0]?.count > 0) files.add(String(filenames?.[lods[0].file]));
    if (Array.isArray(children)) nodes.push(...children);
  }
  return [...files];
}

/** One file in place of those that a JSON text names; null where it names none. */
async function gather(text, find, name, memory) {
  const json = objectOf(text) ?? {};
  if (json.means && json.quats && json.scales)  // SOG
    return archiveOf([['meta.json', text], ...await findAll(imagesOf(json), find, name, memory)]);
  if (json.lodLevels && json.filenames && json.tree) {  // streamed SOG
    const scenes = await findAll(finestFiles(json), find, name, memory);
    const images = scenes.flatMap(([file, bytes]) => imagesOf(objectOf(bytes) ?? {}).map((image) => file.slice(0, file.lastIndexOf('/') + 1) + image));
    return archiveOf([['lod-meta.json', text], ...scenes, ...await findAll(images, find, name, memory)]);
  }
  const outside = json.asset && Array.isArray(json.buffers) ? json.buffers.filter((buffer) => typeof buffer?.uri === 'string' && !buffer.uri.startsWith('data:')) : [];
  if (!outside.length) return null;
  const files = await findAll(outside.map(({uri}) => fileOf(uri, name)), find, name, memory);
  for (const [i, buffer] of outside.entries()) buffer.uri = await asData(files[i][1]);
  return new Blob([JSON.stringify(json)]);
}

/**
 * Reads a stream into the module, and decodes parts of it on the way where that shows something. `find` finds the other
 * files of a scene.
 */
async function readStream(stream, announced, name, memory, find) {
  let size = announced, come = 0, next = announced ? announced / 8 : Infinity, told = 0;
  let address = room(size, name);
  for (const reader = stream.getReader(); ;) {
    const {done, value} = await reader.read().catch((error) => {
      throw failure('read', `${name}: read: the connection ended after ${come} of ${announced || 'an unknown number of'} bytes (${error.message})`);
    });
    if (done) break;
    if (come + value.length > size) {
      size = Math.max(2 * size, come + value.length);
      if (size > memory) throw failure('memory', `${name}: memory: more than ${memory} bytes came; only so many may be used`);
      address = room(size, name);
    }
    module.HEAPU8.set(value, address + come);
    come += value.length;
    if (performance.now() - told > 50) {
      told = performance.now();
      postMessage({progress: {read: come, bytes: announced}});
    }
    if (come >= next && come < announced) {
      const isGlb = module.HEAPU32[address >> 2] === 0x46546c67;
      next = isGlb ? 2 * next : Infinity;
      if (isGlb) decode(name, come, memory, false);
    }
  }
  if (come < announced)
    throw failure('read', `${name}: read: ended after ${come} of ${announced} bytes: it was cut, or is gone`);
  address = room(come, name);
  postMessage({progress: {read: come, bytes: come}});
  const isJson = find && come <= MOST_JSON && module.HEAPU8[address] === 0x7b;  // {
  const whole = isJson ? await gather(module.HEAPU8.slice(address, address + come), find, name, memory) : null;
  if (whole) return readStream(whole.stream(), whole.size, name, memory);
  decode(name, come, memory, true);
}

async function read({source, name, memory, files}) {
  if (typeof source !== 'string') return readStream(source.stream(), source.size, name, memory, amongFiles(files));
  const answer = await request(source, name);
  // A length that is that of compressed bytes is none of what comes
  const encoded = answer.headers.get('content-encoding');
  const announced = encoded ? 0 : Number(answer.headers.get('content-length')) || 0;
  if (announced > memory)
    throw failure('memory', `${name}: memory: the file has ${announced} bytes, but only ${memory} may be used`);
  return readStream(answer.body, announced, name, memory, besideAddress(answer.url));
}

// ---- Sorting

let sorted;  // the scene whose positions are here

function positions({scene, bytes}) {
  sorted = scene;
  module.HEAPU8.set(new Uint8Array(bytes), module._flux_sort_positions(bytes.byteLength / 12));
  module._flux_sort_begin();
}

function sort({scene, ticket, view}) {
  if (scene !== sorted) return;
  module.HEAPU8.set(new Uint8Array(view), module._flux_sort_view());
  const count = module._flux_sort();
  const order = copy(module._flux_sort_order(), 4 * count);
  postMessage({order: {scene, ticket, count, order}}, [order]);
}

async function start(compiled) {
  module = await fluxModule({
    instantiateWasm: (imports, done) => {
      WebAssembly.instantiate(compiled, imports).then((instance) => done(instance, compiled));
      return {};
    },
  });
  postMessage({ready: true});
}

async function handle(data) {
  try {
    if (data.compiled) await start(data.compiled);
    else if (data.read) await read(data.read);
    else if (data.positions) positions(data.positions);
    else if (data.sort) sort(data.sort);
  } catch (error) {
    const problem = error.problem ?? (error instanceof RangeError ? 'memory' : '');
    postMessage({error: {problem, message: String(error.message ?? error)}});
  }
}

// One after the other: what comes while the module starts waits for it
let handled = Promise.resolve();
onmessage = ({data}) => {
  handled = handled.then(() => handle(data));
};
