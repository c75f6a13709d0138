// Image features and their matches between views with known poses.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "trainer/data/dataset.h"

namespace fluxgs {

struct Feature {
  glm::dvec2 pixel{0.0};  ///< in the image; the centre of the first pixel is at (½, ½)
  glm::u8vec3 color{0};   ///< of that pixel, sRGB
  std::array<std::uint8_t, 128> descriptor{};
};

/// At most 2,000 SIFT features (Lowe 2004), found on a copy reduced to at most 800 pixels a side.
std::vector<Feature> find_features(const View& view);

/// Pairs of indices of features that are each other's nearest by descriptor among those near each
/// other's epipolar lines, and clearly nearer than the second (Lowe's ratio 0.8).
std::vector<std::pair<int, int>> match_features(const View& view_a,
                                                const std::vector<Feature>& features_a,
                                                const View& view_b,
                                                const std::vector<Feature>& features_b);

/// The tolerance for epipolar lines and reprojections, in pixels of the image: 2 pixels of the copy
/// that features were found on.
double feature_tolerance(const View& view);

}  // namespace fluxgs
