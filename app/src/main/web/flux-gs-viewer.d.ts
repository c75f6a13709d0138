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
  phase: 'idle' | 'reading' | 'decoding' | 'ready' | 'failed' | 'cancelled';
  read: number;
  /** Of the file; 0 where the server does not say. */
  bytes: number;
  error: string;
  problem: '' | 'memory' | 'network' | 'read' | 'open';
}

export interface State {
  loading: Loading;
  hasScene: boolean;
  drawn: boolean;
  /** Nothing moves, and the picture is as sharp as it gets. */
  resting: boolean;
  motion: '' | 'drift' | 'path' | 'walk';
  error: string;
  stats: {fps: number; frameMs: number; sortMs: number; drawn: number; shown: number; splats: number; width: number;
    height: number; memory: number; shDegree: number; reduced: boolean};
  view: View | null;
}

/** `<flux-gs-viewer src poster view background noui turntable language>`. */
export class FluxGsViewerElement extends HTMLElement {
  /** Opens a scene: a URL, a File or a Blob. The one before stays until it can be shown. */
  open(source: string | Blob, options?: {name?: string; memory?: number; view?: View}): Promise<void>;
  /** Goes to a view smoothly. */
  goTo(view: View): Promise<void>;
  set(changes: Settings): Promise<void>;
  state(): Promise<State | undefined>;
  /** A PNG of the present view; null before there is a scene. */
  picture(): Promise<Blob | null>;
}

declare global {
  interface HTMLElementTagNameMap {
    'flux-gs-viewer': FluxGsViewerElement;
  }
  interface HTMLElementEventMap {
    /** Of <flux-gs-viewer>. */
    ready: CustomEvent<{ms: number}>;
  }
}
