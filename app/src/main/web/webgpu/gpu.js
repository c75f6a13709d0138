// The renderer in WebGPU: projects and sorts in compute shaders, as the one of OpenGL ES 3.1 does. What a frame
// needs comes packed from the module (platform/web/webgpu_device.cpp).
import argumentsText from './arguments.wgsl';
import frameText from './frame.wgsl';
import projectText from './project.wgsl';
import resolveText from './resolve.wgsl';
import sortText from './sort.wgsl';
import splatText from './splat.wgsl';
import {sortsRightly} from './sort_check.js';

// The twins of constants in the shaders
const BLOCK = 2048, RADIX = 256, BATCH = 128, MOST_PASSES = 4;
const THREADS = 128;            // of the projection
const DIGITS_A_GROUP = 16;      // of the scan
const FRAME_BYTES = 160;        // Frame
const SPLAT_BYTES = 32;         // of a projected splat
const SHIFT_STRIDE = 256;       // of dynamic offsets
const STATE_TOTALS = 16;        // bytes before State.totals
const DRAW_OFFSET = 16;         // in the commands
const PATIENCE_MS = 10_000;     // with a browser that has not said whether there is a device

/** What a promise gives within PATIENCE_MS. */
function inTime(promise) {
  let timer;
  const late = new Promise((_, reject) => {
    timer = setTimeout(() => reject(new Error(`no answer for ${PATIENCE_MS / 1000} s`)), PATIENCE_MS);
  });
  return Promise.race([promise, late]).finally(() => clearTimeout(timer));
}

/** A pipeline's inputs by their places: 'uniform', 'read' and 'write' are buffers, 'shift' a part of one. */
function layoutOf(device, visibility, kinds) {
  const types = {uniform: 'uniform', shift: 'uniform', read: 'read-only-storage', write: 'storage'};
  return device.createBindGroupLayout({entries: kinds.map((kind, binding) => ({
    binding,
    visibility,
    ...(kind === 'texture' ? {texture: {sampleType: 'unfilterable-float'}} : {buffer: {type: types[kind], hasDynamicOffset: kind === 'shift'}}),
  }))});
}

/** Buffers, parts of buffers and views of textures, in the order of their places. */
function group(device, layout, resources) {
  return device.createBindGroup({layout, entries: resources.map((resource, binding) =>
    ({binding, resource: resource instanceof GPUBuffer ? {buffer: resource} : resource}))});
}

/**
 * The programs: `pipelines` by their names, those that every frame needs, compiled while other things go on; and
 * `compile(name)` for the others.
 */
async function makePrograms(device, canvasFormat) {
  const stages = GPUShaderStage;
  const module = (text) => device.createShaderModule({code: `${frameText}\n${text}`});
  const layouts = {
    project: layoutOf(device, stages.COMPUTE, ['uniform', 'read', 'read', 'write', 'write']),
    sort: layoutOf(device, stages.COMPUTE, ['shift', 'write', 'read', 'write']),
    arguments: layoutOf(device, stages.COMPUTE, ['uniform', 'write', 'write', 'write']),
    splat: layoutOf(device, stages.VERTEX | stages.FRAGMENT, ['uniform', 'read', 'read']),
    resolve: layoutOf(device, stages.FRAGMENT, ['texture', 'uniform']),
  };
  const layout = (name) => device.createPipelineLayout({bindGroupLayouts: [layouts[name]]});
  const compute = (name, code, entryPoint, constants) => ({layout: layout(name), compute: {module: code, entryPoint, constants}});
  const draw = (name, code, [vertex, fragment], target) => ({layout: layout(name), vertex: {module: code, entryPoint: vertex},
    fragment: {module: code, entryPoint: fragment, targets: [target]}, primitive: {topology: 'triangle-list'}});
  const blend = {color: {srcFactor: 'src-alpha', dstFactor: 'one-minus-src-alpha'}, alpha: {srcFactor: 'one', dstFactor: 'one-minus-src-alpha'}};
  const project = module(projectText), sort = module(sortText), splat = module(splatText);
  const described = {
    project: compute('project', project, 'project', {compensated: 0}),
    projectCompensated: compute('project', project, 'project', {compensated: 1}),
    count: compute('sort', sort, 'count'),
    scan: compute('sort', sort, 'scan'),
    scatter: compute('sort', sort, 'scatter', {last: 0}),
    scatterLast: compute('sort', sort, 'scatter', {last: 1}),
    arguments: compute('arguments', module(argumentsText), 'arguments'),
    resolve: draw('resolve', module(resolveText), ['whole_canvas', 'resolve'], {format: canvasFormat}),
    ...Object.fromEntries(['rgba16float', 'rgba32float'].map((format) => [format, draw('splat', splat, ['corner_of_splat', 'layer'], {format, blend})])),
  };
  const needed = ['project', 'count', 'scan', 'scatter', 'scatterLast', 'arguments', 'resolve', device.features.has('float32-blendable') ? 'rgba32float' : 'rgba16float'];
  const pipelines = {};
  await Promise.all(needed.map(async (name) => {
    const how = described[name];
    pipelines[name] = await (how.compute ? device.createComputePipelineAsync(how) : device.createRenderPipelineAsync(how));
  }));
  const compile = (name) => described[name].compute ? device.createComputePipeline(described[name]) : device.createRenderPipeline(described[name]);
  return {layouts, pipelines, compile};
}

export class Gpu {
  /**
   * The renderer of a canvas; null where the browser has no WebGPU, a processor plays the GPU (unless that is
   * allowed), or it sorts wrongly. The canvas is left as it is then.
   * @param {HTMLCanvasElement} canvas
   * @param {{allowsSoftware?: boolean, failed: (message: string) => void}} options failed: called once, when
   *   something goes wrong later
   */
  static async create(canvas, options) {
    let device;
    try {
      const adapter = await inTime(navigator.gpu?.requestAdapter({powerPreference: 'high-performance'}));
      if (!adapter) return null;
      const isSoftware = adapter.info?.isFallbackAdapter ?? adapter.isFallbackAdapter ?? false;
      if (isSoftware && !options.allowsSoftware) return null;
      const {maxStorageBufferBindingSize, maxBufferSize, maxTextureDimension2D} = adapter.limits;
      device = await inTime(adapter.requestDevice({
        requiredLimits: {maxStorageBufferBindingSize, maxBufferSize, maxTextureDimension2D},
        requiredFeatures: isSoftware && adapter.features.has('float32-blendable') ? ['float32-blendable'] : [],
      }));
      const gpu = new Gpu(canvas, device, isSoftware);
      await gpu.#start();
      gpu.#failed = options.failed;
      return gpu;
    } catch (error) {
      device?.destroy();
      console.info(`WebGL draws in place of WebGPU: ${error.message}`);
      return null;
    }
  }

  #canvas;
  #context;
  #format = navigator.gpu.getPreferredCanvasFormat();
  #failed;
  #programs;
  #frame;     // uniform buffer
  #copied;    // that of the resolve
  #shifts;
  #indices;
  #scene;     // buffers and bind groups
  #image;     // that splats are blended in
  #counts = [];  // small buffers that the number of splats is read through
  #drawn = -1;

  constructor(canvas, device, isSoftware) {
    this.#canvas = canvas;
    this.device = device;
    this.isSoftware = isSoftware;
  }

  async #start() {
    const device = this.device;
    const ended = (message) => {  // at any time from now on
      if (this.isLost) return;
      this.isLost = true;
      this.fault = message;
      this.#failed?.(message);
    };
    device.lost.then(({message}) => ended(message));
    device.addEventListener('uncapturederror', ({error}) => ended(error.message));
    this.#programs = await makePrograms(device, this.#format);
    const {UNIFORM, COPY_DST, INDEX} = GPUBufferUsage;
    this.#frame = this.#buffer(FRAME_BYTES, UNIFORM | COPY_DST);
    this.#copied = this.#buffer(16, UNIFORM | COPY_DST);
    this.#shifts = this.#buffer(SHIFT_STRIDE * MOST_PASSES, UNIFORM | COPY_DST);
    for (let pass = 0; pass < MOST_PASSES; ++pass) device.queue.writeBuffer(this.#shifts, SHIFT_STRIDE * pass, new Uint32Array([8 * pass]));
    const indices = Uint16Array.from({length: 6 * BATCH}, (_, i) => 4 * Math.floor(i / 6) + [0, 1, 2, 2, 1, 3][i % 6]);
    this.#indices = this.#buffer(indices.byteLength, INDEX | COPY_DST);
    device.queue.writeBuffer(this.#indices, 0, indices);
    if (!await sortsRightly(this) || this.isLost) throw new Error('the sort is wrong');
    this.#context = this.#canvas.getContext('webgpu');
    this.#context.configure({device, format: this.#format, alphaMode: 'opaque'});
  }

  #pipeline(name) {
    const {pipelines, compile} = this.#programs;
    return (pipelines[name] ??= compile(name));
  }

  #buffer(size, usage) {
    return this.device.createBuffer({size: Math.max(Math.ceil(size / 4) * 4, 16), usage});
  }

  /** Longest side of an image, bytes of a buffer, and splats that a dispatch can have. */
  get limits() {
    const {maxTextureDimension2D, maxStorageBufferBindingSize, maxBufferSize, maxComputeWorkgroupsPerDimension} = this.device.limits;
    return [maxTextureDimension2D, Math.min(maxStorageBufferBindingSize, maxBufferSize), maxComputeWorkgroupsPerDimension * THREADS - 1];
  }
  get blendsFloats() {
    return this.device.features.has('float32-blendable');
  }

  // ---- The scene

  /** Makes room for so many splats in place of those before; their bytes are then written. */
  makeScene(count, geometryBytes, coefficientBytes) {
    this.dropScene();
    if (count) this.#scene = this.makeBuffers(count, geometryBytes, coefficientBytes);
  }

  makeBuffers(count, geometryBytes, coefficientBytes) {
    const {STORAGE, COPY_DST, COPY_SRC, INDIRECT} = GPUBufferUsage, {layouts} = this.#programs, device = this.device;
    const b = {
      geometry: this.#buffer(geometryBytes, STORAGE | COPY_DST),
      coefficients: this.#buffer(coefficientBytes, STORAGE | COPY_DST),
      projected: this.#buffer(SPLAT_BYTES * (count + 1), STORAGE),
      pairs: [0, 1].map(() => this.#buffer(8 * count, STORAGE | COPY_DST)),
      order: this.#buffer(4 * (count + BATCH), STORAGE | COPY_SRC),
      state: this.#buffer(STATE_TOTALS + 4 * RADIX * (1 + Math.ceil(count / BLOCK)), STORAGE | COPY_DST | COPY_SRC),
      commands: this.#buffer(36, STORAGE | INDIRECT),
    };
    const sort = (source, target) => group(device, layouts.sort, [{buffer: this.#shifts, size: 16}, b.state, source, target]);
    return {count, buffers: b, groups: {
      project: group(device, layouts.project, [this.#frame, b.geometry, b.coefficients, b.projected, b.pairs[0]]),
      // By the number of the pass: its pairs go from one of the two buffers to the other
      sort: [0, 1].map((i) => sort(b.pairs[i], b.pairs[1 - i])),
      sortLast: [0, 1].map((i) => sort(b.pairs[i], b.order)),
      arguments: group(device, layouts.arguments, [this.#frame, b.state, b.order, b.commands]),
      splat: group(device, layouts.splat, [this.#frame, b.projected, b.order]),
    }};
  }

  dropScene() {
    if (this.#scene) this.destroyBuffers(this.#scene);
    this.#scene = undefined;
  }

  destroyBuffers({buffers}) {
    for (const buffer of Object.values(buffers).flat()) buffer.destroy();
  }

  /** `name`: 'geometry' or 'coefficients'. */
  write(name, offset, bytes) {
    this.device.queue.writeBuffer(this.#scene.buffers[name], offset, bytes);
  }

  // ---- The image

  makeImage(width, height, isFloat) {
    this.dropImage();
    const format = isFloat ? 'rgba32float' : 'rgba16float';
    const texture = this.device.createTexture({size: [width, height], format, usage: GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.TEXTURE_BINDING});
    const view = texture.createView();
    this.#image = {format, texture, view, size: [width, height], resolve: group(this.device, this.#programs.layouts.resolve, [view, this.#copied])};
  }
  dropImage() {
    this.#image?.texture.destroy();
    this.#image = undefined;
  }

  // ---- Frames

  /** Enqueues a frame: the bytes of Frame, its background, the size of the part of the image that it takes. */
  draw(frame, {compensated, keyBits, background, width, height}) {
    const encoder = this.device.createCommandEncoder(), scene = this.#scene;
    this.#image.size = [width, height];
    if (scene) {
      this.device.queue.writeBuffer(this.#frame, 0, frame);
      this.device.queue.writeBuffer(scene.buffers.state, 0, new Uint32Array([scene.count]));
      const pass = encoder.beginComputePass();
      pass.setPipeline(this.#pipeline(compensated ? 'projectCompensated' : 'project'));
      pass.setBindGroup(0, scene.groups.project);
      pass.dispatchWorkgroups(Math.floor(scene.count / THREADS) + 1);
      this.sort(pass, scene, keyBits);
      pass.end();
    }
    const [r, g, b] = background;
    const pass = encoder.beginRenderPass({colorAttachments: [{view: this.#image.view, loadOp: 'clear', storeOp: 'store', clearValue: [r, g, b, 0]}]});
    if (scene) {
      pass.setViewport(0, 0, width, height, 0, 1);
      pass.setPipeline(this.#pipeline(this.#image.format));
      pass.setBindGroup(0, scene.groups.splat);
      pass.setIndexBuffer(this.#indices, 'uint16');
      pass.drawIndexedIndirect(scene.buffers.commands, DRAW_OFFSET);
    }
    pass.end();
    const count = scene && this.#copyCount(encoder);
    this.device.queue.submit([encoder.finish()]);
    count?.();
  }

  /** Sorts the pairs of a scene, whose number is in its state, by so many bits of their keys. */
  sort(pass, {count, buffers, groups}, keyBits) {
    const passes = Math.max(2, Math.ceil(keyBits / 8));
    for (let i = 0; i < passes; ++i) {
      const last = i + 1 === passes;
      const dispatch = () => i ? pass.dispatchWorkgroupsIndirect(buffers.commands, 0) : pass.dispatchWorkgroups(Math.max(Math.ceil(count / BLOCK), 1));
      pass.setBindGroup(0, (last ? groups.sortLast : groups.sort)[i % 2], [SHIFT_STRIDE * i]);
      pass.setPipeline(this.#pipeline('count'));
      dispatch();
      pass.setPipeline(this.#pipeline('scan'));
      pass.dispatchWorkgroups(RADIX / DIGITS_A_GROUP);
      pass.setPipeline(this.#pipeline(last ? 'scatterLast' : 'scatter'));
      dispatch();
      if (i) continue;
      pass.setPipeline(this.#pipeline('arguments'));
      pass.setBindGroup(0, groups.arguments);
      pass.dispatchWorkgroups(1);
    }
  }

  /** Has the number of splats of the frame copied; what is to be called once it is submitted. */
  #copyCount(encoder) {
    const free = this.#counts.find(({mapState}) => mapState === 'unmapped') ??
      (this.#counts.length < 3 && this.#buffer(4, GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST));
    if (!free) return undefined;
    if (!this.#counts.includes(free)) this.#counts.push(free);
    encoder.copyBufferToBuffer(this.#scene.buffers.state, 0, free, 0, 4);
    return () => free.mapAsync(GPUMapMode.READ).then(() => {
      [this.#drawn] = new Uint32Array(free.getMappedRange(0, 4));
      free.unmap();
    }, () => {});
  }

  /** Number of splats of the newest frame that the GPU has finished, once; -1 where there is no news. */
  takeDrawn() {
    const drawn = this.#drawn;
    this.#drawn = -1;
    return drawn;
  }

  /** Shows the last frame in the canvas. */
  show() {
    const {width, height} = this.#canvas, [w, h] = this.#image.size;
    this.device.queue.writeBuffer(this.#copied, 0, new Float32Array([w / width, h / height, w, h]));
    const encoder = this.device.createCommandEncoder();
    const pass = encoder.beginRenderPass({colorAttachments: [{view: this.#context.getCurrentTexture().createView(), loadOp: 'clear', storeOp: 'store'}]});
    pass.setPipeline(this.#pipeline('resolve'));
    pass.setBindGroup(0, this.#image.resolve);
    pass.draw(3);
    pass.end();
    this.device.queue.submit([encoder.finish()]);
  }

  /** The last frame as RGBA, its longer side no longer than `longest` pixels unless that is 0. */
  read(longest) {
    this.show();
    const {width, height} = this.#canvas, scale = longest ? Math.min(1, longest / Math.max(width, height)) : 1;
    const canvas = new OffscreenCanvas(Math.max(1, Math.round(width * scale)), Math.max(1, Math.round(height * scale)));
    const context = canvas.getContext('2d', {willReadFrequently: true});
    context.imageSmoothingQuality = 'high';
    context.drawImage(this.#canvas, 0, 0, canvas.width, canvas.height);
    return context.getImageData(0, 0, canvas.width, canvas.height);
  }

  close() {
    this.isLost = true;
    this.device.destroy();
  }
}
