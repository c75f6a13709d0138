// The constants of the image model, shared by the reference, the trainer and the phone's renderer.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "fluxgs/screen_filter.h"

namespace fluxgs {

/// Cut-offs and constants of volume splatting (3DGS, Kerbl et al. 2023; design: "Defaults").
struct RenderOptions {
  double alpha_min = 1.0 / 255.0;   ///< a splat adds nothing to a pixel where α is below this
  double alpha_max = 0.99;          ///< α is limited to this
  double transmittance_min = 1e-4;  ///< a pixel is finished once T falls below this
  std::optional<ScreenFilter> filter = {};  ///< in place of the scene's own
  double near_plane = 0.01;  ///< scene units; splats with centres nearer are not drawn
  /// Splats whose standard deviation along the view direction is larger than this × their depth are
  /// not drawn: they reach behind the camera, and what their footprint says, a veil over the whole
  /// image, is of the linearisation's making. 0: no limit.
  double depth_spread_max = 3;
  double frustum_margin = 0.15;  ///< the Jacobian's point is kept within this fraction of the
                                 ///< image size outside the image (3DGS: 1.3 × half the view)
  int sh_degree = 3;             ///< highest degree to evaluate, 0…3
  glm::dvec3 background{0.0};    ///< RGB, 0…1
};

/// The options with the filter of a scene, unless they name one.
inline RenderOptions for_scene(RenderOptions options, const ScreenFilter& scene) {
  if (!options.filter) options.filter = scene;
  return options;
}

}  // namespace fluxgs
