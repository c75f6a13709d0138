// What a scene's images lose when the scene is stored less exactly.
#pragma once

#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/error.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/core/parallel.h"
#include "trainer/core/planar_image.h"

namespace fluxgs {

/// How many images tell the error of a scene to a few hundredths of a decibel.
inline constexpr int kMeasuringViews = 12;

/// Compares scenes with an exact one by images of the trainer's renderer, limited to 0…1.
class SceneError {
 public:
  /// Renders `exact` once for each of `cameras` (one or more). `threads` must outlive this.
  SceneError(const SplatCloud& exact, std::vector<Camera> cameras, const RenderOptions& options,
             const Threads& threads);

  /// The mean square error over all channels of all pixels of all images.
  Expected<double> mse(const SplatCloud& other) const;

 private:
  std::vector<Camera> cameras_;
  RenderOptions options_;
  const Threads& threads_;
  std::vector<PlanarImage> exact_;
};

}  // namespace fluxgs
