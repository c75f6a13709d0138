// Anti-aliasing: scenes that look right from nearer and farther than their images were taken
// (Mip-Splatting, Yu et al. 2024). Splats are drawn with a compensated ScreenFilter (section 5.2),
// and none is finer than the images can show (section 5.1).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "trainer/model/phase.h"

namespace fluxgs {

struct AntialiasingOptions {
  static constexpr const char* kTitle = "Anti-aliasing";
  bool antialias = false;
  double dilation = 0.3;      ///< px², of the ScreenFilter
  double min_variance = 0.2;  ///< px², of a splat in the training view that shows it largest
  OptionFields fields(const TrainOptions& all);
};

/// Smallest standard deviation of splats at `positions`, scene units, that `cameras` can show: that
/// of `variance` (px²) in the camera that shows a splat largest. 0 where no camera shows it.
std::vector<float> min_deviations(const PlanarFloats& parameters, std::span<const Camera> cameras,
                                  double variance, const Threads& threads);

/// Sets the filter of the renders of a training. Null without anti-aliasing.
std::unique_ptr<Phase> make_antialiasing(TrainOptions& options, const std::vector<View>& views);

}  // namespace fluxgs
