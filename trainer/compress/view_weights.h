// Directions from which the training views see each splat, and its weight in them.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "fluxgs/camera.h"
#include "fluxgs/render_options.h"
#include "trainer/core/parallel.h"
#include "trainer/core/parameters.h"
#include "trainer/core/progress.h"

namespace fluxgs {

/// The most views that are weighed for one purpose: more tell little.
inline constexpr std::size_t kMostWeighedViews = 256;

/// 4 bytes a splat and view: 40 MB for 100,000 splats and 100 views.
struct ViewWeights {
  std::vector<glm::dvec3> centers = {};  ///< of the cameras
  PlanarFloats weights = {};             ///< row v: Σ α·T over the pixels of view v, for each splat
  double pixels = 0;                     ///< of all views together
};

/// `parameters`: rows as in model/parameters.h. A forward pass and one of scores for each view;
/// after a stop the weights of further views are 0.
ViewWeights view_weights(const PlanarFloats& parameters, const std::vector<Camera>& cameras,
                         const RenderOptions& options, const Threads& threads,
                         const WorkControl& control = {});

}  // namespace fluxgs
