// One viewer in one canvas: its instance of the module, the workers that read and sort, and the inputs.
// No user interface; element.js has that.
import {Gpu} from './webgpu/gpu.js';

const PHASES = {pointerdown: 0, pointermove: 1, pointerup: 2, pointercancel: 3};
const KINDS = {moved: 0, button: 1, scrolled: 2, key: 3, text: 4, focusLost: 5};
const VIEW_NUMBERS = 12;
const within = (low, high) => (value) => Number.isFinite(value) && value >= low && value <= high;
const least = (low) => (value) => Number.isFinite(value) && value >= low;
/** A value for people: NaN, too. */
const shown = (value) => typeof value === 'number' ? String(value) : JSON.stringify(value);
/** Of each setting: what it may be, and that for people. */
const SETTINGS = {
  scale: [(value) => value === 0 || within(0.2, 1)(value), '0, or 0.2 to 1'],
  movingScale: [within(0.2, 1), '0.2 to 1'],
  shDegree: [(value) => [0, 1, 2, 3].includes(value), '0, 1, 2 or 3'],
  maxSplats: [within(0, 2 ** 32 - 1), '0 (all) or a number of splats'],
  memory: [least(0), '0 (all there is) or bytes'],
  background: [(value) => Array.isArray(value) && value.length === 3 && value.every(within(0, 1)), 'three numbers from 0 to 1'],
};

export class FluxViewer extends EventTarget {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {{compile: () => Promise<WebAssembly.Module>, glue: string, worker: string}} parts
   * @param {'' | 'webgl' | 'webgpu'} renderer WebGPU where a graphics card has it; one of them, if it is there
   */
  static async create(canvas, parts, renderer = '') {
    const viewer = new FluxViewer();
    await viewer.#start(canvas, parts, renderer);
    return viewer;
  }

  #canvas;
  #parts;
  #compiled;
  #module;
  #gpu;       // the renderer in WebGPU; without it the module draws in WebGL
  #graphics;  // the promise that it is known which; scenes are read meanwhile
  #reader;   // of the scene that is loading
  #sorter;
  #loading = {phase: 'idle', read: 0, bytes: 0, error: '', problem: ''};
  #coarse = false;
  #taken = false;  // something of the scene that was opened last
  #frame = 0;
  #lost = false;
  #ratio = 0;  // pixels of the canvas for one of the page; 0 before the first frame
  #fingers = new Map();
  #settings = {scale: 0, movingScale: 1, shDegree: 3, maxSplats: 0, memory: 0, background: [0, 0, 0]};
  #listeners;
  #resized;

  async #start(canvas, parts, renderer) {
    this.#canvas = canvas;
    this.#parts = parts;
    const gpu = renderer === 'webgl' ? null : Gpu.create(canvas, {allowsSoftware: renderer === 'webgpu', failed: (message) => this.#leaveGpu(message)});
    const [compiled, factory] = await Promise.all([parts.compile(), makeFactory(parts.glue)]);
    this.#compiled = compiled;
    this.#module = await factory({
      canvas,
      sorter: this.#makeSorter(),
      instantiateWasm: (imports, done) => {
        WebAssembly.instantiate(compiled, imports).then((instance) => done(instance, compiled));
        return {};
      },
    });
    this.#graphics = this.#chooseGraphics(gpu);
    this.#listen();
    this.set({});
  }

  async #chooseGraphics(making) {
    const gpu = await making;
    if (!gpu) return;
    this.#gpu = this.#module.gpu = gpu;
    if (gpu.isLost) this.#leaveGpu(gpu.fault);
  }

  /** Draws in WebGL from now on: in another canvas, as a canvas has one kind of context for good. */
  #leaveGpu(message) {
    if (!this.#gpu) return;
    const m = this.#module;
    console.info(`WebGL draws in place of WebGPU: ${message}`);
    const before = this.#canvas, canvas = before.cloneNode(), hadFocus = before.getRootNode().activeElement === before;
    this.#deafen();
    before.replaceWith(canvas);
    this.#canvas = m.canvas = canvas;
    this.#gpu = undefined;  // the module sees that it is lost
    this.#listen();
    if (hadFocus) canvas.focus({preventScroll: true});
    m._flux_redraw();
    this.wake();
    this.#tell('canvas');
  }

  // ---- Workers

  #makeWorker(heard) {
    const text = new Blob([this.#parts.glue, '\n', this.#parts.worker], {type: 'text/javascript'});
    const url = URL.createObjectURL(text);
    const blocked = `a worker cannot start; where the page has a Content-Security-Policy, ${POLICY}`;
    let worker;
    try {
      worker = new Worker(url);
    } catch (error) {
      throw new Error(`${blocked} (${error.message})`);
    }
    worker.onmessage = ({data}) => {
      if (data.ready) URL.revokeObjectURL(url);
      else heard(data);
    };
    worker.onerror = (event) => heard({error: event.message ? {problem: '', message: event.message} : {problem: 'start', message: blocked}});
    worker.postMessage({compiled: this.#compiled});
    return worker;
  }

  /** What the module asks for when splats are to be sorted; one request at a time is on its way. */
  #makeSorter() {
    let busy = false, next;
    const send = (request) => {
      busy = true;
      this.#sorter.postMessage({sort: request}, [request.view]);
    };
    const heard = (data) => {
      busy = false;
      if (data.order) this.#takeOrder(data.order);
      if (data.error) this.#fail(data.error.problem, data.error.message);
      const request = next;
      next = undefined;
      if (request) send(request);
    };
    return {
      positions: (scene, bytes) => {
        this.#sorter ??= this.#makeWorker(heard);
        busy = false;
        next = undefined;
        this.#sorter.postMessage({positions: {scene, bytes: bytes.buffer}}, [bytes.buffer]);
      },
      view: (scene, ticket, view) => {
        const request = {scene, ticket, view: view.buffer};
        if (busy) next = request;
        else send(request);
      },
    };
  }

  #takeOrder({scene, ticket, count, order}) {
    const at = this.#module._flux_order_room(scene, count);
    if (!at) return;
    this.#module.HEAPU8.set(new Uint8Array(order), at);
    this.#module._flux_order_came(ticket, count);
    this.wake();
  }

  // ---- Scenes

  /**
   * Opens a scene: a URL or a Blob. The one before stays until it can be shown.
   * @param {string | URL | Blob} source
   * @param {{name?: string, memory?: number, view?: number[], files?: File[]}} options memory: bytes of the scene;
   *   files: those that a File or Blob may name, as SOG's meta.json does
   * @throws {TypeError | RangeError} of something else, or a view that is none
   */
  open(source, {name, memory = defaultMemory(), view, files = []} = {}) {
    if (source instanceof URL) source = source.href;
    const isUrl = typeof source === 'string';
    if (isUrl ? !source.trim() : !(source instanceof Blob)) throw new TypeError('open: expected a URL, a File or a Blob');
    if (!least(1)(memory)) throw new RangeError(`open: memory is ${shown(memory)}; expected bytes`);
    if (view) checkView(view);
    this.#endReader();
    name = String(name ?? nameOf(source));
    this.#loading = {phase: 'reading', read: 0, bytes: isUrl ? 0 : source.size, error: '', problem: '', name};
    this.#coarse = this.#taken = false;
    queueMicrotask(() => this.#tell('loading'));  // when the caller has noted what is opening
    try {
      if (isUrl) source = addressOf(source, name);
    } catch (error) {
      return this.#fail('network', error.message);
    }
    this.#module._flux_scene_begin();
    let reader;
    const heard = async (data) => {
      if (!data.progress) await this.#graphics;
      if (reader !== this.#reader) return;
      if (data.progress) Object.assign(this.#loading, data.progress);
      if (data.scene) this.#takeScene(data.scene, view);
      if (data.error) this.#fail(data.error.problem, data.error.message);
      if (data.error || data.scene?.whole) this.#endReader();
      this.#tell('loading');
    };
    try {
      reader = this.#reader = this.#makeWorker(heard);
    } catch (error) {
      return this.#fail('start', error.message);
    }
    reader.postMessage({read: {source, name, memory, files: [...files].map((file) => [file.name, file])}});
  }

  cancel() {
    if (!this.#reader) return;
    this.#endReader();
    this.#loading.phase = 'cancelled';
    this.#tell('loading');
  }

  #endReader() {
    this.#reader?.terminate();  // with it goes its memory, which modules never give back
    this.#reader = undefined;
  }

  #fail(problem, message) {
    Object.assign(this.#loading, {phase: 'failed', problem, error: message});
  }

  #takeScene({head, blocks, loading, whole}, view) {
    const m = this.#module;
    const headAt = m._malloc(head.byteLength);
    m.HEAPU8.set(new Uint8Array(head), headAt);
    const at = m._flux_scene_room(headAt);
    m._free(headAt);
    if (!at) return this.#fail('memory', `${this.#loading.name}: memory: not enough to show the scene`);
    blocks.forEach((block, i) => m.HEAPU8.set(new Uint8Array(block), m.HEAPU32[(at >> 2) + 2 * i]));
    m._flux_scene_show(view && !this.#coarse ? this.#writeView(view) : 0);
    this.#coarse = !whole;
    this.#taken = true;
    const {read, bytes, name} = this.#loading;
    this.#loading = {...loading, read, bytes, name, phase: whole ? 'ready' : 'reading'};
    this.wake();
  }

  // ---- Frames

  /** Draws when the browser next does, and goes on for as long as something moves. */
  wake() {
    if (this.#frame || this.#lost) return;
    this.#frame = requestAnimationFrame((ms) => {
      this.#frame = 0;
      if (this.#lost) return;
      this.#fit();
      const goesOn = this.#module._flux_frame(ms / 1000);
      if (goesOn) this.wake();
      this.#tell('frame');
    });
  }

  /** The canvas has as many pixels as the display has where it is, two for each of the page at most. */
  #fit() {
    const canvas = this.#canvas;
    const ratio = Math.min(devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width === width && canvas.height === height && this.#ratio === ratio) return;
    canvas.width = width;
    canvas.height = height;
    this.#ratio = ratio;
    this.#module._flux_resize(width, height, ratio * 160 / 150);
    this.#module._flux_redraw();
  }

  // ---- Inputs

  #listen() {
    const canvas = this.#canvas;
    this.#listeners = new AbortController();
    const on = (target, names, call, options = {}) => {
      for (const name of names.split(' '))
        target.addEventListener(name, call, {signal: this.#listeners.signal, ...options});
    };
    on(canvas, 'pointerdown pointermove pointerup pointercancel', (event) => this.#pointer(event));
    on(canvas, 'wheel', (event) => this.#wheel(event), {passive: false});
    on(canvas, 'contextmenu', (event) => event.preventDefault());
    on(canvas, 'keydown keyup', (event) => this.#key(event));
    on(canvas, 'blur', () => this.#event(KINDS.focusLost));
    on(canvas, 'webglcontextlost', (event) => {
      event.preventDefault();
      this.#lost = true;
      this.#tell('frame');
    });
    on(canvas, 'webglcontextrestored', () => {
      this.#lost = false;
      this.#module._flux_lose_context();
      this.wake();
    });
    on(document, 'visibilitychange', () => document.hidden || this.wake());
    this.#resized = new ResizeObserver(() => this.wake());
    this.#resized.observe(canvas);
  }

  #deafen() {
    this.#listeners.abort();
    this.#resized.disconnect();
  }

  #place(event) {
    const box = this.#canvas.getBoundingClientRect();
    return [(event.clientX - box.left) * this.#ratio, (event.clientY - box.top) * this.#ratio];
  }

  #event(kind, {x = 0, y = 0, button = 0, down = 0, amount = 0, key = 0} = {}) {
    this.#module._flux_event(kind, x, y, button, down, amount, key, performance.now() / 1000);
    this.wake();
  }

  #pointer(event) {
    if (event.pointerType !== 'mouse') return this.#touch(event);
    const [x, y] = this.#place(event);
    if (event.type === 'pointerdown') {
      this.#canvas.setPointerCapture(event.pointerId);
      this.#canvas.focus({preventScroll: true});
    }
    if (event.type === 'pointermove') return this.#event(KINDS.moved, {x, y});
    if (event.button >= 0 && event.button < 3)  // left, middle, right: PointerButton has the same numbers
      this.#event(KINDS.button, {x, y, button: event.button, down: Number(event.type === 'pointerdown')});
  }

  #touch(event) {
    const phase = PHASES[event.type], id = event.pointerId;
    if (phase === 0) {
      this.#canvas.setPointerCapture(id);
      this.#canvas.focus({preventScroll: true});
    } else if (!this.#fingers.has(id)) {
      return;
    }
    this.#fingers.set(id, this.#place(event));
    const m = this.#module, count = this.#fingers.size;
    const at = m._malloc(24 * count);
    [...this.#fingers].forEach(([finger, [x, y]], i) => m.HEAPF64.set([finger, x, y], at / 8 + 3 * i));
    m._flux_touch(phase, id, at, count, event.timeStamp / 1000);
    m._free(at);
    if (phase >= 2) this.#fingers.delete(id);
    this.wake();
  }

  #wheel(event) {
    event.preventDefault();
    const [x, y] = this.#place(event);
    const notch = [100, 3, 1][event.deltaMode];  // pixels, lines or pages of a notch
    this.#event(KINDS.scrolled, {x, y, amount: -event.deltaY / notch * (event.ctrlKey ? 5 : 1)});
  }

  #key(event) {
    // Those with other keys belong to the browser; but what was pressed before them comes up again
    if (event.type === 'keydown' && (event.ctrlKey || event.altKey || event.metaKey)) return;
    const letter = /^(?:Key([A-Z])|Digit([0-9]))$/.exec(event.code);
    const name = letter?.[1] ?? letter?.[2] ?? {ArrowUp: 'W', ArrowDown: 'S', ArrowLeft: 'A', ArrowRight: 'D'}[event.code];
    const down = event.type === 'keydown';
    if (name) this.#event(KINDS.key, {key: name.charCodeAt(0), down: Number(down)});
    if (down && event.key.length === 1) this.#event(KINDS.text, {key: event.key.charCodeAt(0)});
    if (name && event.code.startsWith('Arrow')) event.preventDefault();
  }

  // ---- For the page

  /**
   * Changes some of the settings, see Settings in flux-gs-viewer.d.ts.
   * @throws {RangeError} of a value outside of what stands there; nothing is changed then
   */
  set(changes) {
    if (typeof changes !== 'object' || !changes) throw new TypeError('set: expected an object of settings');
    for (const [name, value] of Object.entries(changes)) {
      if (!Object.hasOwn(SETTINGS, name)) throw new RangeError(`set: there is no setting '${name}'; expected one of ${Object.keys(SETTINGS).join(', ')}`);
      const [holds, expected] = SETTINGS[name];
      if (!holds(value)) throw new RangeError(`set: ${name} is ${shown(value)}; expected ${expected}`);
    }
    Object.assign(this.#settings, changes);
    const s = this.#settings;
    this.#module._flux_set(s.scale, s.movingScale, s.shDegree, s.maxSplats, s.memory, 1 / 60, ...s.background);
    this.wake();
  }
  get settings() {
    return {...this.#settings};
  }

  reset() {
    this.#module._flux_reset_view();
    this.wake();
  }
  flip() {
    this.#module._flux_flip_up();
    this.wake();
  }
  drift(on) {
    this.#module._flux_drift(Number(on));
    this.wake();
  }

  /** Walks at eye height, or no longer. */
  walk(on) {
    this.#module._flux_walk(Number(on));
    this.wake();
  }

  /** Parts of the state that cost nothing to ask for. */
  get loading() {
    return {...this.#loading};
  }
  get lost() {
    return this.#lost;
  }
  /** Whether the picture, once drawn, is one of the scene that was opened last. */
  get taken() {
    return this.#taken;
  }
  get resting() {
    return !this.#frame;
  }
  /** The state of session_json.h, with what the reader says as `loading`. */
  get state() {
    const state = JSON.parse(this.#module.UTF8ToString(this.#module._flux_state()));
    return {...state, loading: this.loading, lost: this.lost, resting: this.resting, renderer: this.#gpu ? 'webgpu' : 'webgl'};
  }

  #writeView(numbers) {
    checkView(numbers);
    const at = this.#module._flux_view_room();
    this.#module.HEAPF64.set(numbers, at / 8);
    return at;
  }
  /** Target, orientation (w, x, y, z), distance, field of view and up: 12 numbers; or null. */
  get view() {
    const at = this.#module._flux_view() / 8;
    return at ? [...this.#module.HEAPF64.subarray(at, at + VIEW_NUMBERS)] : null;
  }
  /** Goes to a view smoothly. */
  goTo(numbers) {
    this.#module._flux_go_to(this.#writeView(numbers));
    this.wake();
  }

  /** The image of the present view as sharp as at rest; null before there is one. */
  image(longest = 0) {
    const m = this.#module, at = m._flux_image(longest);
    if (!at) return null;
    const width = m._flux_image_width(), height = m._flux_image_height();
    const image = new ImageData(new Uint8ClampedArray(m.HEAPU8.slice(at, at + 4 * width * height).buffer), width, height);
    m._flux_image_drop();
    return image;
  }

  /** Ends everything that goes on. */
  close() {
    this.#deafen();
    cancelAnimationFrame(this.#frame);
    this.#lost = true;
    this.#endReader();
    this.#sorter?.terminate();
    this.#graphics.then(() => this.#gpu?.close());
  }

  /** That it draws in; another one after the event "canvas". */
  get canvas() {
    return this.#canvas;
  }

  #tell(name) {
    this.dispatchEvent(new Event(name));
  }
}

/** What a page with a Content-Security-Policy must allow. */
export const POLICY = 'it must allow blob: in script-src and worker-src, and \'wasm-unsafe-eval\' in script-src';

/** The function fluxModule of the glue, which is a classic script: so the workers can have the same text. */
function makeFactory(glue) {
  const url = URL.createObjectURL(new Blob([glue], {type: 'text/javascript'}));
  const script = document.createElement('script');
  script.src = url;
  return new Promise((resolve, reject) => {
    script.onload = () => resolve(globalThis.fluxModule);
    script.onerror = () => reject(new Error(`the page's Content-Security-Policy forbids the viewer's script; ${POLICY}`));
    document.head.append(script);
  }).finally(() => {
    script.remove();
    URL.revokeObjectURL(url);
  });
}

function checkView(numbers) {
  if (numbers?.length !== VIEW_NUMBERS || ![...numbers].every(Number.isFinite)) throw new TypeError(`a view has ${VIEW_NUMBERS} finite numbers`);
}

/** The whole address of a scene. */
function addressOf(source, name) {
  let url;
  try {
    url = new URL(source.trim(), document.baseURI);
  } catch {
    throw new Error(`${name}: is no address of a scene`);
  }
  if (!['http:', 'https:', 'blob:', 'data:'].includes(url.protocol))
    throw new Error(`${name}: an address that begins with ${url.protocol} cannot be fetched; expected https: (open a file of this computer by the button or by dropping it)`);
  return url.href;
}

/** The name of a scene, for people: that of its file. */
function nameOf(source) {
  if (typeof source !== 'string') return source.name ?? 'scene';
  const path = source.split(/[?#]/)[0], name = path.slice(path.lastIndexOf('/') + 1) || source;
  try {
    return decodeURIComponent(name);
  } catch {  // a % of its own
    return name;
  }
}

/** Bytes that a scene may take: a quarter of the device's, as far as browsers tell; less on phones. */
function defaultMemory() {
  const phone = matchMedia('(pointer: coarse)').matches;
  const device = (navigator.deviceMemory ?? (phone ? 2 : 8)) * 2 ** 30;
  return Math.min(device / 4, phone ? 2 ** 29 : 2 ** 31);
}
