// The reference renderer's derivative, in float64, written to be obviously right.
#pragma once

#include <array>
#include <vector>

#include "tools/reference/reference_renderer.h"

namespace fluxgs {

/// ∂L/∂parameter for every splat of a cloud, in the parameters as SplatCloud stores them.
struct ReferenceGradient {
  std::vector<std::array<double, 3>> positions, log_scales, sh_dc;
  std::vector<std::array<double, 4>> rotations;  ///< w, x, y, z
  std::vector<double> opacity_logits;
  std::vector<std::array<double, 3>> sh_rest;  ///< [splat][coefficient] as in SplatCloud
  std::vector<std::array<double, 2>> centers;  ///< with respect to the projected centre, px
};

/// `pixel_gradient` is ∂L/∂colour, 3 channels, the size of the camera's image.
ReferenceGradient reference_gradient(const SplatCloud& cloud, const Camera& camera,
                                     const RenderOptions& options,
                                     const Image<double>& pixel_gradient);

}  // namespace fluxgs
