/** Target, orientation (w, x, y, z), distance, vertical field of view of the shorter side, up. */
export type View = [number, number, number, number, number, number, number, number, number, number, number, number];

export interface Settings {
  /** Of the image that is blended, 0.2 … 1; 0: as many pixels as hold the display's rate. */
  scale?: number;
  /** The largest of that while something moves, 0.2 … 1. */
  movingScale?: number;
  /** 0 … 3. */
  shDegree?: number;
  /** 0: all. */
  maxSplats?: number;
  /** Bytes of graphics memory; 0: all there is. */
  memory?: number;
  /** Red, green, blue, 0 … 1. */
  background?: [number, number, number];
}

export interface Loading {
  phase: 'idle' | 'reading' | 'ready' | 'failed' | 'cancelled';
  /** Of the scene's file, for people. */
  name?: string;
  read: number;
  /** Of the file; 0 where the server does not say. */
  bytes: number;
  error: string;
  problem: '' | 'memory' | 'network' | 'read' | 'open' | 'files' | 'start';
}

export interface State {
  loading: Loading;
  hasScene: boolean;
  /** A picture of the scene was there, with its splats in their order. */
  drawn: boolean;
  /** Nothing moves, and the picture is as sharp as it gets. */
  resting: boolean;
  /** The browser has taken the graphics card away; it comes back by itself. */
  lost: boolean;
  /** What draws. */
  renderer: 'webgpu' | 'webgl';
  motion: '' | 'drift' | 'path' | 'walk';
  error: string;
  stats: {fps: number; frameMs: number; sortMs: number; drawn: number; shown: number; splats: number; width: number;
    height: number; memory: number; shDegree: number; reduced: boolean};
  view: View | null;
}

/**
 * `<flux-gs-viewer src name poster view background noui turntable language renderer>`; those from turntable on are read
 * when the element comes into a page. Calls wait until it is there and its viewer has started; where that cannot start,
 * they are rejected.
 */
export class FluxGsViewerElement extends HTMLElement {
  /**
   * Opens a scene: a URL, a File or a Blob. The one before stays until it can be shown. The promise does not wait for
   * the file: the events `loading`, `ready` and `error` tell what comes of it. `files` are those that a File may name,
   * as a `.gltf` does; `memory` is in bytes. Rejected with a TypeError or RangeError where an argument is none.
   */
  open(source: string | URL | Blob, options?: {name?: string; memory?: number; view?: View; files?: Iterable<File>}): Promise<void>;
  /** Goes to a view smoothly. */
  goTo(view: View): Promise<void>;
  /** Rejected with a RangeError, and nothing is changed, where a value is outside of what stands above. */
  set(changes: Settings): Promise<void>;
  state(): Promise<State>;
  /** A PNG of the present view, with its background; null before there is a scene. */
  picture(): Promise<Blob | null>;
  addEventListener(type: 'loading', listener: (event: CustomEvent<Pick<Loading, 'phase' | 'read' | 'bytes'>>) => void,
    options?: boolean | AddEventListenerOptions): void;
  /** `message` is one line, in English: what was found, and what was expected. */
  addEventListener(type: 'error', listener: (event: CustomEvent<{problem: string; message: string}>) => void,
    options?: boolean | AddEventListenerOptions): void;
  addEventListener(type: string, listener: EventListenerOrEventListenerObject, options?: boolean | AddEventListenerOptions): void;
}

declare global {
  interface HTMLElementTagNameMap {
    'flux-gs-viewer': FluxGsViewerElement;
  }
  interface HTMLElementEventMap {
    /** Of <flux-gs-viewer>: the first picture of a scene is there. */
    ready: CustomEvent<{ms: number}>;
  }
}
