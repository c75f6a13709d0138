// Spark, with the blur of scenes that are trained without antialiasing, and sorted by depth as those are.
import {SparkRenderer, SplatMesh} from '@sparkjsdev/spark';
import * as THREE from 'three';
import {look, makeCamera, makeRenderer} from './three_camera.js';

export async function open(size, url) {
  const renderer = makeRenderer(size), camera = makeCamera(size), scene = new THREE.Scene();
  scene.add(new SparkRenderer({renderer, preBlurAmount: 0.3, blurAmount: 0, sortRadial: false}));
  const mesh = new SplatMesh({url});
  scene.add(mesh);
  await mesh.initialized;
  return {canvas: renderer.domElement, look: (view) => look(camera, view), draw: () => renderer.render(scene, camera)};
}
