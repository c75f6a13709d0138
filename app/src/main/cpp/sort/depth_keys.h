// Depths as integers: what the sorters sort.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include <glm/vec3.hpp>

namespace fluxgs::sort {

/// A key that means: this splat is not drawn.
inline constexpr std::uint32_t kDropped = 0xFFFFFFFFU;

inline constexpr int kFewestKeyBits = 10, kMaxKeyBits = 32;

/// Conversion of a frame's depths to keys. The bits of a positive float, read as an integer, are
/// ordered like the float; they grow with its logarithm, so that a far outlier costs only a few of
/// them. Subtracting the nearest depth's bits and shifting away the last ones leaves a narrow key,
/// and a narrow key needs fewer passes. With no shift the order is exactly that of the float
/// depths.
struct DepthKeys {
  std::uint32_t low = 0;      ///< the bits of the nearest depth
  std::uint32_t shift = 0;    ///< the bits that are left out
  std::uint32_t largest = 0;  ///< no key is larger
  int bits = 0;               ///< that a key has at most
  bool operator==(const DepthKeys&) const = default;
};

/// The keys of at most `bits` bits for depths in [nearest, farthest], both positive and finite.
/// Depths outside get the key of the nearer end. Precondition: nearest ≤ farthest and bits within
/// kFewestKeyBits … kMaxKeyBits.
inline DepthKeys depth_keys(float nearest, float farthest, int bits) {
  const auto low = std::bit_cast<std::uint32_t>(nearest);
  const std::uint32_t range = std::bit_cast<std::uint32_t>(farthest) - low;
  const int shift = std::max(0, static_cast<int>(std::bit_width(range)) - bits);
  const std::uint32_t largest = range >> shift;
  return {low, static_cast<std::uint32_t>(shift), largest,
          std::max(1, static_cast<int>(std::bit_width(largest)))};
}

/// The keys of a view: of the depths beyond `near_plane` that positions in the box `lowest` …
/// `highest` have in it. `centre` is the camera's, `forward` the unit vector along which depth is
/// measured. Precondition: near_plane is positive, bits as above.
inline DepthKeys depth_keys(const glm::dvec3& centre, const glm::dvec3& forward, double near_plane,
                            const glm::dvec3& lowest, const glm::dvec3& highest, int bits) {
  double nearest = 0, farthest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = forward[axis] * (lowest[axis] - centre[axis]);
    const double b = forward[axis] * (highest[axis] - centre[axis]);
    nearest += std::min(a, b);
    farthest += std::max(a, b);
  }
  // A little more than the box, for the rounding of the GPU's depths
  constexpr double kSlack = 1e-4, kLargest = 1e30;
  const double low = std::clamp(nearest * (1 - kSlack), near_plane, kLargest);
  const double high = std::clamp(farthest * (1 + kSlack), low, kLargest);
  return depth_keys(static_cast<float>(low), static_cast<float>(high), bits);
}

/// The key of a positive depth: the twin of depth_key() in shaders/project.comp.
inline std::uint32_t depth_key(const DepthKeys& keys, float depth) {
  const auto bits = std::bit_cast<std::uint32_t>(depth);
  return std::min((std::max(bits, keys.low) - keys.low) >> keys.shift, keys.largest);
}

}  // namespace fluxgs::sort
