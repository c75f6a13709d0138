// The look of the viewer; all of it lies in the element's own shadow tree.
export const style = `
:host { display: block; position: relative; overflow: hidden; contain: content; background: #000; color: #f3f1ec;
  font: 15px/1.45 system-ui, sans-serif; touch-action: none; }
* { box-sizing: border-box; }
canvas, .poster { position: absolute; inset: 0; width: 100%; height: 100%; display: block; }
canvas { outline: none; cursor: grab; }
canvas:active { cursor: grabbing; }
canvas:focus-visible { box-shadow: inset 0 0 0 2px #ffb454; }
.poster { object-fit: cover; transition: opacity .3s; pointer-events: none; }
.poster[hidden] { display: block; opacity: 0; }
.bar { position: absolute; left: 0; right: 0; bottom: max(12px, env(safe-area-inset-bottom)); width: max-content; margin: auto; display: flex;
  flex-wrap: wrap; justify-content: center; gap: 2px; padding: 4px; border-radius: 14px; background: #16181dcc; backdrop-filter: blur(8px);
  max-width: calc(100% - 16px); transition: opacity .3s; }
.bar.faded:not(:focus-within):not(:hover) { opacity: 0; pointer-events: none; }
button, select, input { font: inherit; color: inherit; }
button { border: 0; background: none; border-radius: 10px; cursor: pointer; min-width: 44px; min-height: 44px; padding: 0 10px; }
button:hover { background: #ffffff1f; }
button:focus-visible, select:focus-visible, input:focus-visible { outline: 2px solid #ffb454; outline-offset: -2px; }
button[aria-pressed=true] { color: #ffb454; }
svg { width: 22px; height: 22px; display: block; margin: auto; fill: none; stroke: currentColor; stroke-width: 1.8;
  stroke-linecap: round; stroke-linejoin: round; }
.panel { position: absolute; right: 12px; bottom: 76px; width: min(340px, calc(100% - 24px)); max-height: calc(100% - 100px); overflow: auto;
  padding: 14px 16px; border-radius: 14px; background: #16181df2; }
.panel h2 { font-size: 16px; margin: 0 0 8px; }
.panel label { display: flex; justify-content: space-between; align-items: center; gap: 12px; min-height: 44px; }
.panel select, .panel input[type=number] { background: #2a2d34; border: 1px solid #4a4e57; border-radius: 8px; padding: 8px; max-width: 150px; }
.panel input[type=color] { width: 56px; height: 36px; border: 0; padding: 0; background: none; }
.acts button { display: flex; gap: 12px; align-items: center; width: 100%; text-align: left; }
.acts svg { margin: 0; }
.panel p { margin: 8px 0; }
.note { position: absolute; left: 50%; top: 50%; transform: translate(-50%, -50%); width: min(440px, calc(100% - 32px)); text-align: center;
  padding: 16px 20px; border-radius: 14px; background: #16181de6; overflow-wrap: anywhere; }
.note small { display: block; margin-top: 8px; color: #c9c5bb; font-size: 13px; }
.note progress { width: 100%; height: 6px; margin-top: 12px; accent-color: #ffb454; }
.statistics { position: absolute; left: 12px; top: 12px; margin: 0; padding: 8px 12px; border-radius: 10px; background: #16181dcc;
  font: 12px/1.5 ui-monospace, monospace; pointer-events: none; white-space: pre; }
.toast { position: absolute; left: 0; right: 0; top: 16px; width: max-content; max-width: calc(100% - 16px); margin: auto; padding: 8px 16px; border-radius: 10px; background: #16181de6; }
.over { position: absolute; inset: 8px; border: 3px dashed #ffb454; border-radius: 14px; pointer-events: none; }
[hidden] { display: none; }
@media (prefers-reduced-motion: reduce) { * { transition: none !important; } }
`;

/** Outlines of the buttons, drawn in a square of 24. */
export const icons = {
  open: 'M3 7h6l2 2h10v10H3z M12 16v-5 M9.5 13.5 12 11l2.5 2.5',
  reset: 'M4 11 12 4l8 7 M6 10v10h12V10 M10 20v-6h4v6',
  turn: 'M4 12c0-3 4-5 8-5s8 2 8 5-4 5-8 5 M14 14l-2.5 3 2.5 3',
  walk: 'M13 4.5a1 1 0 1 0 0-.1z M12 8l-3 3v3 M12 8l1 6 3 6 M12 8l3 3h3 M12 14l-2 6-2 1',
  flip: 'M12 3v18 M8 7l4-4 4 4 M8 17l4 4 4-4',
  save: 'M6 4h12v16l-6-4-6 4z',
  fullscreen: 'M4 9V4h5 M15 4h5v5 M20 15v5h-5 M9 20H4v-5',
  picture: 'M4 7h4l2-2h4l2 2h4v12H4z M12 16a3 3 0 1 0 0-6 3 3 0 0 0 0 6',
  link: 'M10 14a4 4 0 0 0 6 0l3-3a4 4 0 0 0-6-6l-1 1 M14 10a4 4 0 0 0-6 0l-3 3a4 4 0 0 0 6 6l1-1',
  settings: 'M4 7h10 M18 7h2 M16 5v4 M4 17h2 M10 17h10 M8 15v4',
  help: 'M9 9a3 3 0 1 1 4 2.8c-1 .5-1 1.2-1 2.2 M12 18v.1',
  statistics: 'M5 20V10 M12 20V4 M19 20v-7',
};
