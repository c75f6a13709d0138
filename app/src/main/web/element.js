// <flux-gs-viewer src="scene.glb">: a viewer with its buttons, for any page.
import {FluxViewer} from './core.js';
import {parts, inlineBytes} from './parts.js';
import {icons, style} from './style.js';
import {fill, textsFor} from './texts.js';

const EXTENSIONS = '.glb,.gltf,.ply,.spz,.splat,.sog,.zip';
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

/** "#rrggbb" as red, green, blue, 0 … 1; black for what is none. */
function colour(text) {
  const digits = /^#?([0-9a-f]{6})$/i.exec(text ?? '')?.[1] ?? '000000';
  return [0, 2, 4].map((i) => parseInt(digits.slice(i, i + 2), 16) / 255);
}

/** The numbers of a view in a link, or undefined. */
export function viewOf(text) {
  const numbers = (text ?? '').split(',').map(Number);
  return numbers.length === 12 && numbers.every(Number.isFinite) ? numbers : undefined;
}

const linked = (view) => view.map((number) => Number(number.toPrecision(7))).join();

/**
 * Attributes: src (URL of a scene), name, poster (URL of a picture for the first second), view (12 numbers),
 * background (#rrggbb), noui (no buttons), turntable (auto-orbit from the start), language.
 * Events: "loading", "ready", "error" (detail: problem and message), "view".
 */
export class FluxGsViewerElement extends HTMLElement {
  static observedAttributes = ['src', 'background', 'noui'];

  #root = this.attachShadow({mode: 'open'});
  #texts;
  #viewer;      // once it is there
  #starting;    // the promise of it
  #source;      // that is open
  #title = '';
  #ready = false;
  #began = 0;
  #looked = 0;  // at the state
  #fade;
  #ui = {};
  #statisticsTimer;

  connectedCallback() {
    if (this.#starting) return;
    const asked = this.getAttribute('language');
    const {texts, language} = textsFor(asked ? [asked] : undefined);
    this.#texts = texts;
    this.#build(language);
    this.#starting = this.#start();
  }

  disconnectedCallback() {
    clearInterval(this.#statisticsTimer);
    this.#viewer?.close();
    this.#viewer = this.#starting = undefined;
    this.#root.replaceChildren();
  }

  attributeChangedCallback(name, before, now) {
    if (!this.#starting || before === now) return;
    if (name === 'src' && now) this.open(now);
    if (name === 'background') this.#starting.then(() => this.#viewer?.set({background: colour(now)}));
    if (name === 'noui') this.#ui.bar.hidden = now !== null;
  }

  // ---- The calls that pages have; each waits for the viewer to be there

  /** Opens a scene: a URL, a File or a Blob. */
  async open(source, options = {}) {
    await this.#starting;
    if (!this.#viewer) return;
    this.#source = source;
    this.#ready = false;
    this.#began = performance.now();
    this.#title = options.name ?? (typeof source === 'string' ? decodeURIComponent(source.split(/[?#]/)[0].split('/').pop()) : source.name) ?? '';
    this.#viewer.open(source, {view: viewOf(this.getAttribute('view')), ...options});
    this.#listKept();
  }
  /** Goes to a view: 12 numbers, see FluxViewer.view. */
  async goTo(view) {
    await this.#starting;
    this.#viewer?.goTo(view);
  }
  /** Changes settings, see FluxViewer.set(). */
  async set(changes) {
    await this.#starting;
    this.#viewer?.set(changes);
  }
  /** The state, with the present view. */
  async state() {
    await this.#starting;
    return this.#viewer && {...this.#viewer.state, view: this.#viewer.view};
  }
  /** A PNG of the present view as a Blob, or null before there is a scene. */
  async picture() {
    await this.#starting;
    const image = this.#viewer?.image();
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
    ui.picker = make('input', {type: 'file', accept: EXTENSIONS, hidden: true, 'aria-label': t.open});
    ui.picker.addEventListener('change', () => ui.picker.files[0] && this.open(ui.picker.files[0]));
    ui.turn = button('turn', () => this.#turn(), {pressed: 'false'});
    ui.bar = make('div', {class: 'bar', role: 'toolbar', 'aria-label': t.scene, hidden: this.hasAttribute('noui')},
      button('open', () => ui.picker.click()), button('reset', () => this.#viewer?.reset()), ui.turn,
      button('fullscreen', () => this.#fullscreen()), button('settings', () => this.#show(ui.settings)), button('help', () => this.#show(ui.help)));
    const acts = {flip: () => this.#viewer?.flip(), save: () => this.#keep(), link: () => this.#copyLink(), picture: () => this.#savePicture()};
    ui.settings = this.#buildSettings(...Object.entries(acts).map(([name, act]) => button(name, act, {text: t[name]})),
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
    const picker = make('input', {type: 'color', value: this.getAttribute('background') ?? '#000000', 'aria-label': t.background});
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
    root.addEventListener('keydown', (event) => event.key === 'Escape' && this.#show(null));
    this.addEventListener('dragover', (event) => {
      event.preventDefault();
      ui.over.hidden = false;
    });
    this.addEventListener('dragleave', () => (ui.over.hidden = true));
    this.addEventListener('drop', (event) => {
      event.preventDefault();
      ui.over.hidden = true;
      const file = event.dataTransfer.files[0];
      const url = event.dataTransfer.getData('text/uri-list').split('\n')[0];
      if (file || url) this.open(file ?? url);
    });
  }

  async #start() {
    try {
      const test = document.createElement('canvas').getContext('webgl2');
      if (!test) return this.#tellError('webgl', '');
      test.getExtension('WEBGL_lose_context')?.loseContext();
      this.#viewer = await FluxViewer.create(this.#ui.canvas, parts);
    } catch (error) {
      return this.#tellError('', String(error.message ?? error));
    }
    this.#viewer.addEventListener('loading', () => this.#tellLoading());
    this.#viewer.addEventListener('frame', () => this.#drawn());
    this.#viewer.set({background: colour(this.getAttribute('background'))});
    const inline = await inlineBytes('flux-gs-scene');
    const src = this.getAttribute('src');
    // Not waited for: open() waits for this function
    if (inline) setTimeout(() => this.open(new File([inline], this.getAttribute('name') ?? 'scene')));
    else if (src) setTimeout(() => this.open(src));
    else if (!this.hasAttribute('noui')) this.#note(this.#texts.drop);
    this.#appear();
  }

  // ---- What is shown over the scene

  #note(text, {detail, progress, cancel} = {}) {
    const note = this.#ui.note;
    note.hidden = !text;
    if (!text) return note.replaceChildren();
    const children = [text];
    if (progress !== undefined) children.push(make('progress', progress === null ? {max: 1} : {max: 1, value: progress}));
    if (detail) children.push(make('small', {}, detail));
    if (cancel) {
      const button = make('button', {type: 'button'}, this.#texts.cancel);
      button.addEventListener('click', () => this.#viewer.cancel());
      children.push(button);
    }
    note.replaceChildren(...children);
  }

  #tellLoading() {
    const {phase, read, bytes, error, problem} = this.#viewer.loading;
    const t = this.#texts;
    this.dispatchEvent(new CustomEvent('loading', {detail: {phase, read, bytes}}));
    if (phase === 'failed') return this.#tellError(problem, error);
    if (phase === 'cancelled') return this.#note('');
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
    this.#note(text, {detail: message});
    this.dispatchEvent(new CustomEvent('error', {detail: {problem, message}}));
  }

  #drawn() {
    const t = this.#texts, now = performance.now();
    if (this.#viewer.lost) return this.#note(t.lost);
    // The whole state is text that is made and read again: not in each frame of a movement
    if (this.#ready && !this.#viewer.resting && now - this.#looked < LOOK_MS) return;
    this.#looked = now;
    const state = this.#viewer.state;
    this.#ui.turn.setAttribute('aria-pressed', String(state.motion === 'drift'));
    if (state.error) return this.#tellError('', state.error);
    if (this.#ui.note.textContent === t.lost) this.#note('');
    if (!state.drawn || this.#ready || !['ready', 'reading'].includes(state.loading.phase)) return;
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

  async #copyLink() {
    const view = this.#viewer?.view;
    if (!view) return;
    const url = new URL(location.href);
    if (typeof this.#source === 'string') url.searchParams.set('url', this.#source);
    url.hash = `view=${linked(view)}`;
    await navigator.clipboard?.writeText(url.href).then(() => this.#toast(this.#texts.copied), () => this.#toast(url.href));
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
      const s = this.#viewer.state.stats;
      statistics.textContent = [`${s.fps.toFixed(0)} fps  ${s.frameMs.toFixed(1)} ms`, `${s.drawn.toLocaleString()} of ${s.splats.toLocaleString()} splats, SH ${s.shDegree}`,
        `${s.width}×${s.height}`, `sorted in ${s.sortMs.toFixed(0)} ms`, `${(s.memory / 1e6).toFixed(0)} MB graphics`].join('\n');
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
