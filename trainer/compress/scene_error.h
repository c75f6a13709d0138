// Mean square error between renders of a scene and of a compressed one.
#pragma once

#include <functional>
#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/error.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/core/parallel.h"
#include "trainer/core/planar_image.h"

namespace fluxgs {

/// Number of images that give the error of a scene to a few hundredths of a decibel.
inline constexpr int kEvaluationCameras = 12;

/// Compares scenes with an uncompressed one by images of the trainer's renderer, limited to 0…1.
class SceneError {
 public:
  /// Renders `uncompressed` once for each of `cameras` (one or more). `threads` must outlive this.
  /// `stop` is asked before each image of mse(), which then fails.
  SceneError(const SplatCloud& uncompressed, std::vector<Camera> cameras,
             const RenderOptions& options, const Threads& threads, std::function<bool()> stop = {});

  /// The mean square error over all channels of all pixels of all images.
  Expected<double> mse(const SplatCloud& other) const;

 private:
  std::vector<Camera> cameras_;
  RenderOptions options_;
  const Threads& threads_;
  std::function<bool()> stop_;
  std::vector<PlanarImage> expected_;
};

}  // namespace fluxgs
