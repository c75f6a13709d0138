// Images of a scene from known poses, as a NeRF-synthetic data set.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/error.h"
#include "fluxgs/image.h"
#include "tools/capture/scenes.h"

namespace fluxgs::capture {

struct CaptureOptions {
  int width = 320, height = 240;  ///< pixels, 1…8192
  int train = 40, test = 8;       ///< views, train ≥ 1
  std::uint64_t seed = 1;         ///< of the poses and the textures' noise
  int samples = 4;                ///< n×n rays a pixel, 1…16
  int points = 0;                 ///< on the surfaces, 0…5,000,000; the data set's sparse points
  bool occluder = false;          ///< something moves through the training views; masks show where
  SceneKind scene = SceneKind::kSpheres;
};

struct CaptureCameras {
  std::vector<Camera> train, test;
};

/// Upright cameras where somebody would stand who photographs the scene: on a dome before the
/// spheres, around the middle outdoors, all over the room, in a plane before the wall. Named r_000,
/// r_001, …
CaptureCameras capture_cameras(const CaptureOptions& options);

/// One image, sRGB. The same for any number of threads.
Image<std::uint8_t> render_view(const Scene& scene, const Camera& camera, int samples);

/// Write train/, test/, transforms_train.json and transforms_test.json into a folder, which is
/// created, with an occluder masks/train/, and with points points3d.ply. Errors: options out of
/// range, the folder cannot be written.
Expected<void> write_capture(const std::filesystem::path& folder, const CaptureOptions& options);

}  // namespace fluxgs::capture
