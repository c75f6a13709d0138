// Gauss–Newton blocks of the images' squared error by the shapes of splats.
#pragma once

#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/render_options.h"
#include "trainer/core/parallel.h"
#include "trainer/core/parameters.h"
#include "trainer/core/progress.h"

namespace fluxgs {

/// Lower triangles of 3×3 for each splat, as in SensitivityWeights.
struct ShapeHessian {
  std::vector<float> scale, rotation;
};

/// Σ over all pixels and colours of the squares of what changes there if one splat's scales or
/// rotation change by a little: diagonal blocks JᵀJ of the images' Jacobian J. Estimated as
/// Hutchinson (1990) does traces: a backward pass from random signs s gives g = Jᵀ·s, and the
/// mean of g·gᵀ is JᵀJ. Always the same signs: the result is the same for any number of threads.
/// After a stop further views count nothing.
ShapeHessian shape_hessian(const PlanarFloats& parameters, const std::vector<Camera>& cameras,
                           const RenderOptions& options, const Threads& threads,
                           const WorkControl& control = {});

}  // namespace fluxgs
