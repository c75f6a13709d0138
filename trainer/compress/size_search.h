// Number of splats for a file's size: fewer of them leave more bits for each.
#pragma once

#include <cstddef>

#include "fluxgs/error.h"
#include "fluxgs/io/compact_glb.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/compress/scene_error.h"
#include "trainer/compress/scene_reduction.h"
#include "trainer/core/progress.h"

namespace fluxgs {

/// A scene of fewer splats and the steps that bring its file to the size.
struct SizedScene {
  SplatCloud cloud;
  QuantizationSteps steps;
  double mse = 0;  ///< of the file's renders to those of the whole scene
};

/// Bytes of a file.
struct SizeLimit {
  std::size_t bytes = 0;
  std::size_t beside = 0;  ///< of them for what is not splats
};

/// Takes splats from `reduction` until the compact file within the limit has the least `error` (to
/// the whole scene), by a first look at each number (CompactSearch::first_within_bytes), 20% fewer
/// each time. `start`: steps to begin with, and what is not searched for; sensitivities must be
/// empty, being those of single splats. Fails where even one splat does not fit, and after a stop.
Expected<SizedScene> splats_within_bytes(SceneReduction& reduction, const SceneError& error,
                                         CompactOptions start, const SizeLimit& limit,
                                         const WorkControl& control = {});

}  // namespace fluxgs
