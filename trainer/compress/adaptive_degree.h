// Adaptive SH degrees: the lowest degree of each splat that is good enough.
//
// A splat's loss at a degree is Σ w_v·|c(d_v) − fit(d_v)|²: its unexplained variance times its
// contribution. The losses add up to a bound: a pixel's colour is Σ aᵢ·cᵢ with aᵢ = α·T and
// Σ aᵢ ≤ 1, so it changes by |Σ aᵢ·Δcᵢ|² ≤ Σ aᵢ·|Δcᵢ|² (Jensen), and cutting colours off at 0 only
// makes changes smaller. The square error of all views together is never above the sum of the
// splats' losses; as neighbours err in different directions, it is usually far below: 5 to 8 times
// on two captures.
//
// Judged by floats at equal loss, the least cost loss + λ·floats for each splat would save less
// than 1.1% over a plain threshold (on the same captures, at 1, 10 and 100 millionths of mean
// square error).
#pragma once

#include <cstdint>
#include <vector>

#include "trainer/compress/fit_splats.h"

namespace fluxgs {

/// For each splat the least degree (0…3) whose loss is at most `threshold` (≥ 0, square colours ×
/// pixels). Then fit_to_views() with these degrees.
std::vector<std::uint8_t> min_degrees(const Unexplained& unexplained, double threshold);

/// The bound above for the images' mean square error, over all channels of `pixels` pixels (> 0;
/// ViewWeights::pixels), when every splat is fitted with its degree.
double degree_loss(const Unexplained& unexplained, const std::vector<std::uint8_t>& degrees,
                   double pixels);

/// The largest threshold that matters and whose min_degrees() have a degree_loss() of `mse` at
/// most; 0 where only splats without any loss can change.
double threshold_for(const Unexplained& unexplained, double pixels, double mse);

}  // namespace fluxgs
