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

/** Reads a stream into the module, and decodes parts of it on the way where that shows something. */
async function readStream(stream, announced, name, memory) {
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
  room(come, name);
  postMessage({progress: {read: come, bytes: come}});
  decode(name, come, memory, true);
}

async function read({source, name, memory}) {
  if (typeof source !== 'string') return readStream(source.stream(), source.size, name, memory);
  const answer = await request(source, name);
  // A length that is that of compressed bytes is none of what comes
  const encoded = answer.headers.get('content-encoding');
  const announced = encoded ? 0 : Number(answer.headers.get('content-length')) || 0;
  if (announced > memory)
    throw failure('memory', `${name}: memory: the file has ${announced} bytes, but only ${memory} may be used`);
  return readStream(answer.body, announced, name, memory);
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
