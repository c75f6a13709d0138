// Training with the numbers that a compact file will hold. Images, and so gradients, are those of
// the rounded scene; what steps teach is remembered exactly, and rounded anew now and then (the
// straight-through estimator, Bengio et al. 2013). The paper tunes its codebooks in the same way
// ("Attributes Compression").
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/error.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/compress/compact_search.h"
#include "trainer/core/parallel.h"
#include "trainer/model/train_state.h"

namespace fluxgs {

/// How near the images of a file are to be.
struct CompactGoal {
  std::vector<Camera> cameras;  ///< errors cost what they do in all of these, a dozen measure them
  RenderOptions render;
  double decibels = 40;
};

/// The smallest compact file of `cloud` (finite, some splats) found whose images are within the
/// goal of those of `shown`: the same splats with the colours that they are shown with, which
/// `cloud` need not have where networks make them. `start`: steps to begin with and what is not
/// searched for.
Expected<CompactTrial> compact_within(const SplatCloud& cloud, const SplatCloud& shown,
                                      const CompactGoal& goal, CompactOptions start,
                                      const Threads& threads,
                                      const std::function<void(const CompactTrial&)>& on_trial);

/// Rounds the parameters of a state with the steps and costs of its `rounding`: what they are
/// without their last offsets, if there are any. The splats then have the order of the file, in
/// which those of equal depth are drawn; the optimiser's moments of rotations follow these to where
/// a file's quaternions lie. Returns the file, which holds exactly this scene. On an
/// error, which names the attribute, nothing has changed.
Expected<std::vector<std::byte>> round_parameters(TrainState& state);

}  // namespace fluxgs
