// Splats hidden at random, another set in each step, so that no view's colours come to hang on a
// few splats that only it sees: DropGaussian (Park et al. 2025), which does it for the fewest of
// views.
#pragma once

#include <vector>

#include "trainer/core/parameters.h"
#include "trainer/core/random.h"
#include "trainer/model/options.h"

namespace fluxgs {

/// The share of the splats that one step hides, 0…0.2: TrainOptions::dropout over the number of
/// training views, growing linearly over the run. The fewer views there are, the less they say
/// about what another one shows; with hundreds nearly nothing is hidden.
double dropout_share(const TrainOptions& options, std::size_t views, int iteration);

class Dropout {
 public:
  /// Hides each splat with probability `share` (< 1), and makes the opacities of the others
  /// 1/(1 − share) times what they are, up to kOpaque, so that the image is the same on average.
  /// Share 0 does nothing and draws no random numbers.
  void hide(PlanarFloats& parameters, double share, Random& random);

  /// Exchanges the altered opacities with the true ones, and again back.
  void exchange(PlanarFloats& parameters);

  /// Gives all splats their opacities back, and turns the gradients of the altered opacities (a
  /// row) into those of the true ones.
  void restore(PlanarFloats& parameters, float* opacity_gradient);

  static constexpr double kOpaque = 0.99;  ///< rasterised opacities end here, too

 private:
  std::vector<float> logits_;  // the others of the two; empty: nothing is hidden
};

}  // namespace fluxgs
