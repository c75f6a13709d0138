// GaussianSplats3D. It evaluates harmonics to degree 2.
import {SceneRevealMode, Viewer} from '@mkkellogg/gaussian-splats-3d';
import {look, makeCamera, makeRenderer} from './three_camera.js';

export async function open(size, url) {
  const renderer = makeRenderer(size), camera = makeCamera(size);
  const viewer = new Viewer({renderer, camera, selfDrivenMode: false, useBuiltInControls: false, gpuAcceleratedSort: false,
    sharedMemoryForWorkers: false, ignoreDevicePixelRatio: true, sphericalHarmonicsDegree: 2, sceneRevealMode: SceneRevealMode.Instant,
    inMemoryCompressionLevel: 0, rootElement: document.body});
  await viewer.addSplatScene(url, {showLoadingUI: false, progressiveLoad: false});
  return {
    canvas: renderer.domElement,
    look: (view) => look(camera, view),
    draw: () => {
      viewer.forceRenderNextFrame();
      viewer.update();
      viewer.render();
    },
  };
}
