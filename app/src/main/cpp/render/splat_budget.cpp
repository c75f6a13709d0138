#include "render/splat_budget.h"
#include "fluxgs/math/logistic.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fluxgs::render {

double contribution(const SplatCloud& cloud, std::size_t i) {
  const glm::dvec3 s = glm::exp(glm::dvec3(cloud.log_scales[i]));
  const double opacity = sigmoid(double{cloud.opacity_logits[i]});
  const double value = opacity * (s.x * s.y + s.y * s.z + s.z * s.x) / 3;
  return std::isnan(value) ? 0 : value;
}

std::vector<std::uint32_t> max_contributing(const SplatCloud& cloud, std::size_t count) {
  std::vector<double> values(cloud.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = contribution(cloud, i);
  std::vector<std::uint32_t> splats(cloud.size());
  std::iota(splats.begin(), splats.end(), 0U);
  if (count >= splats.size()) return splats;
  std::ranges::nth_element(splats, splats.begin() + static_cast<std::ptrdiff_t>(count),
                           [&](std::uint32_t a, std::uint32_t b) {
                             return values[a] != values[b] ? values[a] > values[b] : a < b;
                           });
  splats.resize(count);
  std::ranges::sort(splats);
  return splats;
}

}  // namespace fluxgs::render
