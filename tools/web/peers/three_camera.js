// A camera of three.js for the two viewers that are made with it.
import * as THREE from 'three';

export const makeCamera = ({width, height}) => new THREE.PerspectiveCamera(50, width / height, 0.05, 500);

export function look(camera, {position, target, up, fovY}) {
  camera.position.set(...position);
  camera.up.set(...up);
  camera.fov = fovY;
  camera.lookAt(...target);
  camera.updateProjectionMatrix();
  camera.updateMatrixWorld();
}

export function makeRenderer({width, height}) {
  const renderer = new THREE.WebGLRenderer({antialias: false});
  renderer.setPixelRatio(1);
  renderer.setSize(width, height);
  renderer.setClearColor(0x000000, 1);
  document.body.append(renderer.domElement);
  return renderer;
}
