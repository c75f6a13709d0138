#include "codec/importance.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "codec/same_everywhere.h"
#include "io/activation.h"

namespace fluxgs::codec {
namespace {

constexpr float kFlattest = 6.5f;            // thinner ones look the same
constexpr float kMinOpacity = 1e-3f;         // fainter ones are not drawn
constexpr float kFinest = 6, kCoarsest = 2;  // logarithms of the step over the mean one

}  // namespace

std::vector<Extent> extents_of(std::span<const glm::vec3> log_scales) {
  std::vector<Extent> extents;
  extents.reserve(log_scales.size());
  for (const glm::vec3& scales : log_scales) {
    const glm::vec3 s = glm::clamp(scales, -kLongest, kLongest);
    const float longest = std::max({s.x, s.y, s.z}), shortest = std::min({s.x, s.y, s.z});
    const float middle = std::max(std::min(s.x, s.y), std::min(std::max(s.x, s.y), s.z));
    const float least = longest - kFlattest;
    extents.emplace_back(longest, std::max(middle, least), std::max(shortest, least), 0.0f);
  }
  return extents;
}

void set_opacities(std::span<Extent> extents, std::span<const float> opacity_logits) {
  for (std::size_t i = 0; i < extents.size(); ++i)
    extents[i].w = same_log(std::max(io::sigmoid(opacity_logits[i]), kMinOpacity));
}

double mean_importance(const Importance& importance, std::span<const Extent> extents) {
  double sum = 0;
  for (const Extent& extent : extents) sum += double{glm::dot(importance, extent)};
  return sum / static_cast<double>(extents.size());
}

std::vector<float> coarseness_of(const Importance& importance, std::span<const Extent> extents) {
  std::vector<float> result;
  result.reserve(extents.size());
  for (const Extent& extent : extents) result.push_back(glm::dot(importance, extent));
  const auto mean = static_cast<float>(mean_importance(importance, extents));
  for (float& x : result) x = same_exp(std::clamp(mean - x, -kFinest, kCoarsest));
  return result;
}

}  // namespace fluxgs::codec
