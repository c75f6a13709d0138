// The screen-space filter that a scene was trained with and must be drawn with.
#pragma once

namespace fluxgs {

/// A low-pass filter on the image: a 2D Gaussian that every footprint is convolved with, so that no
/// splat falls between pixels.
struct ScreenFilter {
  double dilation = 0.3;  ///< px², > 0, its variance: added to the diagonal of the projected
                          ///< covariance Σ, which becomes Σ′
  /// Multiplies opacities by √(det Σ / det Σ′), so that a splat smaller than a pixel keeps its
  /// total weight when it is widened ("antialiased", Mip-Splatting, Yu et al. 2024, section 5.2).
  /// False: classic 3DGS, which makes such splats brighter.
  bool compensated = false;

  /// True if both members are equal.
  friend bool operator==(const ScreenFilter&, const ScreenFilter&) = default;
};

}  // namespace fluxgs
