// <flux-gs-viewer src="scene.glb">: a viewer with its buttons, for any page.
import {FluxViewer} from './core.js';
import {parts, inlineBytes} from './parts.js';
import {icons, style} from './style.js';
import {fill, textsFor} from './texts.js';

const EXTENSIONS = '.glb,.gltf,.ply,.spz,.splat,.sog,.zip';
const PARTS = '.json,.webp,.bin';  // files of scenes that have several
const QUALITIES = {automatic: {scale: 0, movingScale: 1}, sharp: {scale: 1, movingScale: 1}, fast: {scale: 0, movingScale: 0.7}};
const LOOK_MS = 250;  // between looks at the state while something moves
const FADE_MS = 4000;  // without a touch the buttons go

/** Makes an element: tag, attributes, children. */
function make(tag, attributes = {}, ...children) {
  const svg = tag === 'svg' || tag === 'path';
  const element = svg ? document.createElementNS('http://www.w3.org/2000/svg', tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes))
    if (value === true) element.setAttribute(name, '');
    else if (value !== false && value !== undefined) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/** "#rrggbb" of that, without its #, or of three digits; black for what is none. */
function hexColour(text) {
  const short = /^#?([0-9a-f]{3})$/i.exec(text ?? '')?.[1];
  return `#${short?.replace(/./g, '$&$&') ?? /^#?([0-9a-f]{6})$/i.exec(text ?? '')?.[1] ?? '000000'}`;
}
/** Red, green, blue, 0 … 1. */
const colour = (text) => [1, 3, 5].map((i) => parseInt(hexColour(text).slice(i, i + 2), 16) / 255);

/** The numbers of a view in a link, or undefined. */
export function viewOf(text) {
  const numbers = (text ?? '').split(',').map(Number);
  return numbers.length === 12 && numbers.every(Number.isFinite) ? numbers : undefined;
}

const linked = (view) => view.map((number) => Number(number.toPrecision(7))).join();

/**
 * Attributes: src (URL of a scene), name, poster (URL of a picture for the first second), view (12 numbers),
 * background (#rrggbb), noui (no buttons), turntable (auto-orbit from the start), renderer (webgl or webgpu; otherwise
 * WebGPU where a graphics card has it), language, linked (this page's address takes ?url= and #view=, so that there is a
 * button for links).
 * Events: "loading", "ready", "error" (detail: problem and message), "view".
 */
export class FluxGsViewerElement extends HTMLElement {
  static observedAttributes = ['src', 'background', 'noui'];

  #root = this.attachShadow({mode: 'open'});
  #texts;
  #viewer;      // once it is there
  #starting;    // the promise of it
  #fault = '';  // why it cannot start
  #connected;   // the promise of being in a page, and what fulfils it
  #connect;
  #source;      // that is open, or will be when this is in a page
  #options = {};
  #before = {settings: {}};  // of the viewer before this was moved in its page, with its view
  #title = '';
  #ready = false;
  #began = 0;
  #looked = 0;  // at the state
  #fade;
  #ui = {};
  #statisticsTimer;

  constructor() {
    super();
    this.#waitForPage();
  }

  #waitForPage() {
    this.#connected = new Promise((resolve) => (this.#connect = resolve));
  }

  connectedCallback() {
    if (this.#starting) return;
    this.#connect();
    const asked = this.getAttribute('language');
    const {texts, language} = textsFor(asked ? [asked] : undefined);
    this.#texts = texts;
    this.#build(language);
    this.#starting = this.#start();
  }

  disconnectedCallback() {
    clearInterval(this.#statisticsTimer);
    if (this.#viewer) this.#before = {settings: this.#viewer.settings, view: this.#ready && this.#viewer.view || this.#before.view};
    this.#viewer?.close();
    this.#viewer = this.#starting = undefined;
    this.#ready = false;
    this.#waitForPage();
    this.#root.replaceChildren();
  }

  attributeChangedCallback(name, before, now) {
    if (name === 'src') this.#source = this.#before.view = undefined;  // what was open no longer counts
    if (name === 'background') delete this.#before.settings.background;
    if (!this.#starting || before === now) return;
    if (name === 'src' && now) this.#openShown(now);
    if (name === 'background') this.#starting.then(() => this.#viewer?.set({background: colour(now)}));
    if (name === 'noui') this.#ui.bar.hidden = now !== null;
  }

  // ---- The calls that pages have; each waits for the viewer to be there

  async #there() {
    while (!this.#viewer) {
      await this.#connected;
      await this.#starting;
      if (this.#fault) throw new Error(this.#fault);
    }
    return this.#viewer;
  }

  /** Opens a scene: a URL, a File or a Blob. What comes of it is told by the events. */
  async open(source, options = {}) {
    const viewer = await this.#there();
    viewer.open(source, {view: viewOf(this.getAttribute('view')), ...options});  // throws before anything is changed
    [this.#source, this.#options] = [source, options];
    this.#before.view = undefined;
    this.#ready = false;
    this.#began = performance.now();
    this.#title = viewer.loading.name;
    this.#listKept();
  }
  /** The same for what people chose: they see what goes wrong. */
  #openShown(source, options) {
    this.open(source, options).catch((error) => this.#fault || this.#tellError('network', error.message));
  }
  /** Opens one of the files that people chose together; it may name others of them. */
  #openFiles(files) {
    const all = [...files], named = (pattern) => all.find(({name}) => pattern.test(name));
    const file = named(/^lod-meta\.json$/) ?? named(/^meta\.json$/) ?? named(/\.gltf$/i) ?? all[0];
    if (file) this.#openShown(file, {files: all});
  }
  /** Goes to a view: 12 numbers, see FluxViewer.view. */
  async goTo(view) {
    (await this.#there()).goTo(view);
  }
  /** Changes settings, see FluxViewer.set(). */
  async set(changes) {
    (await this.#there()).set(changes);
  }
  /** The state, with the present view. */
  async state() {
    const viewer = await this.#there();
    return {...viewer.state, view: viewer.view};
  }
  /** A PNG of the present view as a Blob, or null before there is a scene. */
  async picture() {
    const image = (await this.#there()).image();
    if (!image) return null;
    const canvas = make('canvas', {width: image.width, height: image.height});
    canvas.getContext('2d').putImageData(image, 0, 0);
    return new Promise((resolve) => canvas.toBlob(resolve));
  }
  /** The viewer without buttons, or undefined. */
  get viewer() {
    return this.#viewer;
  }

  // ---- Building

  #build(language) {
    const t = this.#texts, ui = this.#ui;
    const button = (name, act, {pressed, text = ''} = {}) => {
      const element = make('button', {type: 'button', title: t[name], 'aria-label': t[name], 'aria-pressed': pressed, 'data-name': name},
        make('svg', {viewBox: '0 0 24 24', 'aria-hidden': 'true'}, make('path', {d: icons[name]})), text);
      element.addEventListener('click', () => act(element));
      return element;
    };
    ui.canvas = make('canvas', {tabindex: 0, role: 'application', 'aria-label': t.scene});
    ui.poster = make('img', {class: 'poster', alt: '', src: this.getAttribute('poster') ?? false, hidden: !this.hasAttribute('poster')});
    ui.picker = make('input', {type: 'file', multiple: true, accept: `${EXTENSIONS},${PARTS}`, hidden: true, 'aria-label': t.open});
    ui.picker.addEventListener('change', () => this.#openFiles(ui.picker.files));
    ui.turn = button('turn', () => this.#turn(), {pressed: 'false'});
    ui.bar = make('div', {class: 'bar', role: 'toolbar', 'aria-label': t.scene, hidden: this.hasAttribute('noui')},
      button('open', () => ui.picker.click()), button('reset', () => this.#viewer?.reset()), ui.turn,
      button('fullscreen', () => this.#fullscreen()), button('settings', () => this.#show(ui.settings)), button('help', () => this.#show(ui.help)));
    ui.walk = button('walk', () => this.#walk(), {pressed: 'false', text: t.walk});
    const acts = {flip: () => this.#viewer?.flip(), save: () => this.#keep(), ...(this.hasAttribute('linked') && {link: () => this.#copyLink()}),
      picture: () => this.#savePicture()};
    ui.settings = this.#buildSettings(ui.walk, ...Object.entries(acts).map(([name, act]) => button(name, act, {text: t[name]})),
      button('statistics', (e) => this.#toggleStatistics(e), {pressed: 'false', text: t.statistics}));
    ui.help = make('div', {class: 'panel', role: 'dialog', 'aria-label': t.help, tabindex: -1, hidden: true}, make('h2', {}, t.help),
      ...[t.helpTouch, t.helpMouse, t.helpKeys].map((text) => make('p', {}, text)), this.#closeButton());
    ui.note = make('div', {class: 'note', role: 'status', 'aria-live': 'polite', hidden: true});
    ui.statistics = make('pre', {class: 'statistics', hidden: true});
    ui.toast = make('div', {class: 'toast', role: 'status', hidden: true});
    ui.over = make('div', {class: 'over', hidden: true});
    this.#root.replaceChildren(make('style', {}, style), make('div', {lang: language, style: 'position:absolute;inset:0'},
      ui.canvas, ui.poster, ui.over, ui.statistics, ui.note, ui.toast, ui.settings, ui.help, ui.bar, ui.picker));
    this.#listen();
  }

  #closeButton() {
    const element = make('button', {type: 'button'}, this.#texts.close);
    element.addEventListener('click', () => this.#show(null));
    return element;
  }

  #buildSettings(...buttons) {
    const t = this.#texts;
    const choice = (label, values, act) => {
      const select = make('select', {'aria-label': label}, ...values.map(([value, text]) => make('option', {value}, text)));
      select.addEventListener('change', () => act(select.value));
      return make('label', {}, label, select);
    };
    const splats = [250_000, 500_000, 1_000_000, 2_000_000].map((n) => [n, n.toLocaleString()]);
    const picker = make('input', {type: 'color', value: hexColour(this.getAttribute('background')), 'aria-label': t.background});
    picker.addEventListener('input', () => this.#viewer?.set({background: colour(picker.value)}));
    this.#ui.kept = make('div');
    return make('div', {class: 'panel', role: 'dialog', 'aria-label': t.settings, tabindex: -1, hidden: true}, make('div', {class: 'acts'}, ...buttons),
      make('h2', {}, t.settings), choice(t.quality, Object.keys(QUALITIES).map((q) => [q, t[q]]), (q) => this.#viewer?.set(QUALITIES[q])),
      choice(t.splats, [[0, t.all], ...splats], (n) => this.#viewer?.set({maxSplats: Number(n)})),
      choice(t.harmonics, [3, 2, 1, 0].map((n) => [n, n]), (n) => this.#viewer?.set({shDegree: Number(n)})),
      make('label', {}, t.background, picker), this.#ui.kept, this.#closeButton());
  }

  #listen() {
    const ui = this.#ui, root = this.#root;
    for (const name of ['pointerdown', 'pointermove', 'keydown', 'wheel', 'focusin'])
      root.addEventListener(name, () => this.#appear(), {passive: true});
    root.addEventListener('keydown', (event) => {
      if (event.key !== 'Escape') return;
      if (ui.note.dataset.error) this.#note('');
      this.#show(null);
    });
    this.addEventListener('dragover', (event) => {
      event.preventDefault();
      ui.over.hidden = false;
    });
    this.addEventListener('dragleave', () => (ui.over.hidden = true));
    this.addEventListener('drop', (event) => {
      event.preventDefault();
      ui.over.hidden = true;
      if (event.dataTransfer.files.length) return this.#openFiles(event.dataTransfer.files);
      const url = event.dataTransfer.getData('text/uri-list').split(/\r?\n/).find((line) => line && !line.startsWith('#'));
      if (url) this.#openShown(url);
    });
  }

  async #start() {
    this.#fault = '';
    try {
      const test = document.createElement('canvas').getContext('webgl2');
      if (!test) return this.#cannotStart('webgl', 'this browser has no WebGL 2');
      test.getExtension('WEBGL_lose_context')?.loseContext();
      const canvas = this.#ui.canvas, viewer = await FluxViewer.create(canvas, parts, this.getAttribute('renderer') ?? '');
      if (canvas !== this.#ui.canvas || !this.isConnected) return viewer.close();  // taken out of the page meanwhile
      this.#viewer = viewer;
    } catch (error) {
      return this.#cannotStart('start', String(error.message ?? error));
    }
    this.#viewer.addEventListener('loading', () => this.#tellLoading());
    this.#viewer.addEventListener('frame', () => this.#drawn());
    this.#viewer.addEventListener('canvas', () => (this.#ui.canvas = this.#viewer.canvas));
    this.#viewer.set({background: colour(this.getAttribute('background')), ...this.#before.settings});
    const inline = await inlineBytes('flux-gs-scene');
    // What was open before this was moved in its page, then what the address asks for
    const source = this.#source ?? this.getAttribute('src') ?? (inline && new File([inline], this.getAttribute('name') ?? 'scene'));
    // Not waited for: open() waits for this function
    const {view} = this.#before;
    if (source) setTimeout(() => this.#openShown(source, {...this.#options, ...(view && {view})}));
    else if (!this.hasAttribute('noui')) this.#note(this.#texts.drop);
    this.#appear();
  }

  #cannotStart(problem, message) {
    this.#fault = message;
    this.#tellError(problem, problem === 'start' ? message : '');
  }

  // ---- What is shown over the scene

  #note(text, {detail, progress, cancel, error = false} = {}) {
    const note = this.#ui.note;
    note.hidden = !text;
    note.dataset.error = error ? 'yes' : '';
    if (!text) return note.replaceChildren();
    const children = [text];
    if (progress !== undefined) children.push(make('progress', progress === null ? {max: 1} : {max: 1, value: progress}));
    if (detail) children.push(make('small', {}, detail));
    if (cancel) {
      const button = make('button', {type: 'button'}, this.#texts.cancel);
      button.addEventListener('click', () => this.#viewer.cancel());
      children.push(button);
    }
    if (error && this.#viewer?.state.hasScene) {  // the scene before is behind it
      const button = make('button', {type: 'button'}, this.#texts.close);
      button.addEventListener('click', () => this.#note(''));
      children.push(button);
    }
    note.replaceChildren(...children);
  }

  #tellLoading() {
    const {phase, read, bytes, error, problem} = this.#viewer.loading;
    const t = this.#texts;
    this.dispatchEvent(new CustomEvent('loading', {detail: {phase, read, bytes}}));
    if (phase === 'failed') return this.#tellError(problem, error);
    if (phase === 'cancelled') {
      this.#ui.poster.hidden = true;
      return this.#note('');
    }
    if (phase === 'ready') return this.#note('');
    const part = bytes ? read / bytes : null;
    const passed = (performance.now() - this.#began) / 1000;
    const left = part > 0 && passed > 1 ? fill(t.left, Math.ceil(passed / part - passed)) : '';
    const done = bytes > 0 && read >= bytes;
    const coarse = this.#ready;
    if (!coarse) this.#note(fill(done ? t.decoding : t.reading, this.#title), {progress: done ? null : part, detail: done ? '' : left, cancel: true});
  }

  #tellError(problem, message) {
    const t = this.#texts;
    const text = t[problem] ?? (problem === 'open' ? t.network : t.damaged);
    this.#note(text, {detail: message, error: true});
    this.dispatchEvent(new CustomEvent('error', {detail: {problem, message}}));
  }

  #drawn() {
    if (!this.#viewer) return;
    const t = this.#texts, now = performance.now();
    if (this.#viewer.lost) return this.#note(t.lost);
    // The whole state is text that is made and read again: not in each frame of a movement
    if (this.#ready && !this.#viewer.resting && now - this.#looked < LOOK_MS) return;
    this.#looked = now;
    const state = this.#viewer.state;
    this.#ui.turn.setAttribute('aria-pressed', String(state.motion === 'drift'));
    this.#ui.walk.setAttribute('aria-pressed', String(state.motion === 'walk'));
    if (state.error) return this.#tellError('', state.error);
    if (this.#ui.note.textContent === t.lost) this.#note('');
    if (!state.drawn || this.#ready || !this.#viewer.taken || !['ready', 'reading'].includes(state.loading.phase)) return;
    this.#ready = true;
    this.#ui.poster.hidden = true;
    this.#note('');
    if (state.stats.reduced) this.#toast(fill(t.reduced, state.stats.shown.toLocaleString(), state.stats.splats.toLocaleString()));
    if (this.hasAttribute('turntable')) this.#viewer.drift(true);
    this.dispatchEvent(new CustomEvent('ready', {detail: {ms: performance.now() - this.#began}}));
  }

  #toast(text) {
    this.#ui.toast.textContent = text;
    this.#ui.toast.hidden = false;
    setTimeout(() => (this.#ui.toast.hidden = true), 4000);
  }

  #appear() {
    const bar = this.#ui.bar;
    bar.classList.remove('faded');
    clearTimeout(this.#fade);
    this.#fade = setTimeout(() => this.#ready && bar.classList.add('faded'), FADE_MS);
  }

  /** Shows one panel, or none; the one that is shown goes. */
  #show(panel) {
    const {settings, help, canvas} = this.#ui;
    const shows = panel?.hidden ?? false;
    settings.hidden = help.hidden = true;
    if (shows) {
      panel.hidden = false;
      panel.focus();
    } else {
      canvas.focus();
    }
  }

  // ---- What the buttons do

  #turn() {
    this.#viewer?.drift(this.#viewer.state.motion !== 'drift');
  }

  #walk() {
    this.#viewer?.walk(this.#viewer.state.motion !== 'walk');
    this.#show(null);
  }

  async #copyLink() {
    const view = this.#viewer?.view;
    if (!view) return;
    const url = new URL(location.href);
    if (this.#source instanceof Blob) url.searchParams.delete('url');  // nobody else has that file
    else url.searchParams.set('url', this.#source);
    url.hash = `view=${linked(view)}`;
    try {
      await navigator.clipboard.writeText(url.href);
      this.#toast(this.#texts.copied);
    } catch {  // not allowed, or a page without https
      this.#toast(url.href);
    }
  }

  async #savePicture() {
    const blob = await this.picture();
    if (!blob) return;
    const url = URL.createObjectURL(blob);
    make('a', {href: url, download: `${this.#title || 'scene'}.png`}).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  }

  #fullscreen() {
    if (document.fullscreenElement) document.exitFullscreen();
    else this.requestFullscreen?.();
  }

  #toggleStatistics(button) {
    const {statistics} = this.#ui;
    statistics.hidden = !statistics.hidden;
    button.setAttribute('aria-pressed', String(!statistics.hidden));
    clearInterval(this.#statisticsTimer);
    if (statistics.hidden) return;
    const tell = () => {
      if (!this.#viewer) return;
      const {stats: s, renderer} = this.#viewer.state;
      statistics.textContent = [`${s.fps.toFixed(0)} fps  ${s.frameMs.toFixed(1)} ms`, `${s.drawn.toLocaleString()} of ${s.splats.toLocaleString()} splats, SH ${s.shDegree}`,
        `${s.width}×${s.height}, ${renderer === 'webgpu' ? 'WebGPU' : 'WebGL'}`, `sorted in ${s.sortMs.toFixed(0)} ms`, `${(s.memory / 1e6).toFixed(0)} MB graphics`].join('\n');
    };
    tell();
    this.#statisticsTimer = setInterval(tell, 500);
  }

  // Views that people keep lie in the browser, by the scene's name
  #keptKey() {
    return `flux-gs views ${this.#title}`;
  }
  #kept() {
    try {
      return JSON.parse(localStorage.getItem(this.#keptKey()) ?? '[]').filter((view) => viewOf(String(view)));
    } catch {  // private windows may have no storage
      return [];
    }
  }
  #setKept(views) {
    try {
      localStorage.setItem(this.#keptKey(), JSON.stringify(views));
    } catch {}
    this.#listKept();
  }
  #keep() {
    const view = this.#viewer?.view;
    if (!view || !this.#ready) return;
    this.#setKept([...this.#kept(), view]);
    this.#toast(fill(this.#texts.view, this.#kept().length));
  }
  #listKept() {
    const t = this.#texts, views = this.#kept();
    const rows = views.map((view, i) => {
      const go = make('button', {type: 'button'}, fill(t.view, i + 1));
      const forget = make('button', {type: 'button', 'aria-label': fill(t.forget, i + 1), title: fill(t.forget, i + 1)}, '×');
      go.addEventListener('click', () => this.#viewer.goTo(view));
      forget.addEventListener('click', () => this.#setKept(views.filter((_, j) => j !== i)));
      return make('label', {}, go, forget);
    });
    this.#ui.kept.replaceChildren(...(rows.length ? [make('h2', {}, t.kept), ...rows] : []));
  }
}

if (!customElements.get('flux-gs-viewer')) customElements.define('flux-gs-viewer', FluxGsViewerElement);
