// A sample of the splats of a cloud, for estimates of its size and shape.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "fluxgs/math/logistic.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs::camera {

/// More would not change the estimates, but keep the viewer waiting.
inline constexpr std::size_t kLargestSample = 100'000;

/// The finite splats among every n-th of the cloud, n such that there are no more than
/// kLargestSample.
inline std::vector<std::size_t> even_sample(const SplatCloud& cloud) {
  const std::size_t step = cloud.size() / kLargestSample + (cloud.size() % kLargestSample != 0);
  std::vector<std::size_t> sample;
  for (std::size_t i = 0; i < cloud.size(); i += step)
    if (is_finite(cloud, i)) sample.push_back(i);
  return sample;
}

/// 0…1.
inline double opacity_of(const SplatCloud& cloud, std::size_t i) {
  return sigmoid(double{cloud.opacity_logits[i]});
}

}  // namespace fluxgs::camera
