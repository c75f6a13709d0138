// PlayCanvas's engine, without its tone mapping.
import * as pc from 'playcanvas';

export async function open({width, height}, url) {
  const canvas = document.createElement('canvas');
  document.body.append(canvas);
  const device = await pc.createGraphicsDevice(canvas, {deviceTypes: [pc.DEVICETYPE_WEBGL2], antialias: false});
  device.maxPixelRatio = 1;
  const options = new pc.AppOptions();
  Object.assign(options, {graphicsDevice: device, componentSystems: [pc.CameraComponentSystem, pc.GSplatComponentSystem],
    resourceHandlers: [pc.GSplatHandler]});
  const app = new pc.AppBase(canvas);
  app.init(options);
  app.setCanvasFillMode(pc.FILLMODE_NONE, width, height);
  app.setCanvasResolution(pc.RESOLUTION_FIXED, width, height);
  const asset = new pc.Asset('scene', 'gsplat', {url});
  await new Promise((resolve, reject) => {
    asset.on('load', resolve);
    asset.on('error', reject);
    app.assets.add(asset);
    app.assets.load(asset);
  });
  const splats = new pc.Entity(), camera = new pc.Entity();
  splats.addComponent('gsplat', {asset});
  camera.addComponent('camera', {clearColor: new pc.Color(0, 0, 0, 1), nearClip: 0.05, farClip: 500, toneMapping: pc.TONEMAP_NONE,
    gammaCorrection: pc.GAMMA_SRGB});
  app.root.addChild(splats);
  app.root.addChild(camera);
  app.start();
  return {
    canvas,
    look: ({position, target, up, fovY}) => {
      camera.setPosition(...position);
      camera.lookAt(new pc.Vec3(...target), new pc.Vec3(...up));
      camera.camera.fov = fovY;
      app.renderNextFrame = true;
    },
  };
}
