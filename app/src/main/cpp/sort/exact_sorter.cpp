#include "sort/exact_sorter.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace fluxgs::sort {

void sort_exactly(const std::vector<glm::vec3>& positions, const SortView& view,
                  std::vector<double>& depths, std::vector<std::uint32_t>& indices) {
  depths.resize(positions.size());
  indices.clear();
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    depths[i] = glm::dot(view.forward, glm::dvec3(positions[i]) - view.centre);
    if (depths[i] > view.near_plane) indices.push_back(i);  // false for NaN
  }
  std::ranges::stable_sort(indices, {}, [&](std::uint32_t i) { return depths[i]; });
  std::ranges::reverse(indices);
}

Expected<std::unique_ptr<ExactSorter>> ExactSorter::create(gl::Api& api, OrderPlace place) {
  std::unique_ptr<ExactSorter> sorter(new ExactSorter(api, place));
  if (auto ok = sorter->set_scene(0, 0, {}); !ok) return std::unexpected(ok.error());
  return sorter;
}

Expected<void> ExactSorter::set_scene(std::uint32_t count, std::uint32_t spare,
                                      std::vector<glm::vec3> positions) {
  positions_ = std::move(positions);
  depths_.reserve(count);
  indices_.reserve(count);
  uploaded_ = {};  // There may not be room for both
  return gl::assign_or_error(UploadedOrder::create(api_, std::size_t{count} + spare, place_),
                             uploaded_);
}

void ExactSorter::sort(const SortView& view, const gl::Buffer* /*keys*/) {
  sort_exactly(positions_, view, depths_, indices_);
  uploaded_.write(indices_);
}

}  // namespace fluxgs::sort
