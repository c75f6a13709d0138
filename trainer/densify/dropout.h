// Dropout: each iteration hides another random set of splats, so that no view's colours come to
// depend on a few splats that only it sees. DropGaussian (Park et al. 2025) does so for the fewest
// of views.
#pragma once

#include <memory>
#include <vector>

#include "trainer/model/phase.h"

namespace fluxgs {

struct DropoutOptions {
  static constexpr const char* kTitle = "Dropout";
  double dropout = 0;  ///< × training views: share of hidden splats at the end; 0: off

  OptionFields fields(const TrainOptions& all);
};

/// The share of the splats that one iteration hides, 0…0.2: `dropout` over the number of training
/// views, growing linearly over the run. The fewer views there are, the less they say about what
/// another one shows; with hundreds nearly nothing is hidden.
double dropout_share(double dropout, std::size_t views, int iteration, int iterations);

/// Hides each splat with probability `share` (< 1), and makes the opacities of the others
/// 1/(1 − share) times what they are, up to kOpaque, so that the image is the same on average.
/// Returns the true opacity logits. Share 0 does nothing, draws no random numbers and returns
/// nothing.
std::vector<float> hide_splats(PlanarFloats& parameters, double share, Random& random);

/// Gives all splats their opacities back, and turns the gradients of the changed opacities (a row)
/// into those of the true ones.
void restore_splats(PlanarFloats& parameters, const std::vector<float>& true_opacities,
                    float* opacity_gradient);

inline constexpr double kOpaque = 0.99;  ///< rasterised opacities end here, too

/// Null where the options hide nothing.
std::unique_ptr<Phase> make_dropout(TrainOptions& options);

}  // namespace fluxgs
