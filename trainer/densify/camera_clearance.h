// Camera clearance: photos are taken from free space, so that no splat may have a camera inside.
// Splats that do are floaters: a view sees one as a faint colour over all of the image, which
// training views correct with other splats, and a view beside them does not.
#pragma once

#include <memory>
#include <vector>

#include <glm/vec3.hpp>

#include "trainer/core/parallel.h"
#include "trainer/core/parameters.h"
#include "trainer/model/phase.h"

namespace fluxgs {

struct CameraClearanceOptions {
  static constexpr const char* kTitle = "Camera clearance";
  /// Least Mahalanobis distance (standard deviations of the splat) of cameras from a splat; 0: off
  double clearance = 0;

  OptionFields fields(const TrainOptions& all);
};

/// Makes splats smaller that have any of `cameras` (centres of projection, world) nearer than
/// `clearance` standard deviations, so that the nearest is as far as that, but at least a quarter
/// of their size.
void clear_cameras(const std::vector<glm::dvec3>& cameras, double clearance,
                   PlanarFloats& parameters, const Threads& threads);

/// Null where the options ask for none.
std::unique_ptr<Phase> make_camera_clearance(const TrainOptions& options);

}  // namespace fluxgs
