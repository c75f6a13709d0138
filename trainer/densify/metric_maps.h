// Maps of badly and of well reconstructed pixels (paper, "Photometric Loss Guidance").
#pragma once

#include "trainer/core/planar_image.h"
#include "trainer/densify/splat_scores.h"

namespace fluxgs {

/// Two planes of a loss_map(): M⁺, which is 1 where the loss is above τ⁺ and otherwise 0, and the
/// loss itself where it is below τ⁻ and otherwise 0 (ℒ·M⁻). With ScoreUnit::percentile τ± are
/// fractions of the image's 99.5th percentile of the loss, which one outlier pixel does not move,
/// or of kMinUnit if that is larger, so that a perfect image has no bad pixels. NaN counts as bad.
/// Pixels that are 0 in `used` (1 channel; empty: none are) count as perfect and have no part in
/// the percentile; the maps then have a third plane, 1 where pixels count (Rasterizer::score).
PlanarImage metric_maps(const PlanarImage& loss, const ScoreOptions& options,
                        const Image<std::uint8_t>& used = {});

/// A loss that is hardly visible.
inline constexpr float kMinUnit = 0.02f;

}  // namespace fluxgs
