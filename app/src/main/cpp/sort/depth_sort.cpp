#include "sort/depth_sort.h"

#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

namespace fluxgs::sort {
namespace {

// Splats farther than this from the direction of view are left out: cos 120°. No field of view
// together with the turn of the camera during one sort gets there.
constexpr float kFarthestCosine = -0.5F;

// As the GPU computes it (shaders/project.comp), but for splats behind the camera, which might come
// into view before the next order is ready: those lie in front of all others.
std::uint32_t key_of(const glm::vec3& position, const glm::vec3& centre, const glm::vec3& forward,
                     const DepthKeys& keys) {
  const glm::vec3 ray = position - centre;
  const float depth = glm::dot(forward, ray);
  if (depth > 0) return depth_key(keys, depth);
  const bool near_enough = depth >= kFarthestCosine * glm::length(ray);  // false for NaN
  return near_enough ? 0 : kDropped;
}

}  // namespace

DepthSort::DepthSort(std::vector<glm::vec3> positions)
    : positions_(std::move(positions)), keys_(positions_.size()), scratch_(positions_.size()) {}

std::uint32_t DepthSort::sort(const SortView& view, std::span<std::uint32_t> order) {
  const glm::vec3 centre(view.centre), forward(view.forward);
  for (std::size_t i = 0; i < positions_.size(); ++i)
    keys_[i] = key_of(positions_[i], centre, forward, view.keys);
  return radix_sort(keys_, view.keys.bits, scratch_, order);
}

}  // namespace fluxgs::sort
