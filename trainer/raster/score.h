// Scores of splats: sums of maps over the pixels that a splat contributes to.
#pragma once

namespace fluxgs {

/// By what a map's value at a pixel is multiplied before it is added to a splat's score: the
/// splat's α there (paper, "Multi-view Alpha-Weighted Error Accumulation"), or the share α·T that
/// it really has in the pixel's colour.
enum class ScoreWeight { alpha, alpha_transmittance };

/// Rows of the scores of one image, sums over the pixels that a splat contributes to.
namespace score {
inline constexpr int first = 0;         // Σ w·map of the first map
inline constexpr int second = 1;        // … of the second
inline constexpr int contribution = 2;  // Σ α·T
inline constexpr int pixels = 3;        // how many there are
inline constexpr int count = 4;
}  // namespace score

/// Rows of what the removal of each splat alone would do to one image.
namespace removal {
inline constexpr int change = 0;  // of Σ |C − target|² over pixels and channels; may be negative
inline constexpr int pixels = 1;  // that the splat contributes to
inline constexpr int count = 2;
}  // namespace removal

}  // namespace fluxgs
