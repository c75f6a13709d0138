// Sorting the splats of a scene by their depth in a view, on the CPU.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sort/cpu_radix_sort.h"
#include "sort/sorter.h"

namespace fluxgs::sort {

/// The positions of a scene and the room to sort them in: 32 bytes a splat. Not thread-safe.
class DepthSort {
 public:
  /// The positions are relative to the scene's origin; splats that are not finite are never listed.
  explicit DepthSort(std::vector<glm::vec3> positions);

  std::size_t size() const { return positions_.size(); }

  /// Writes the order of a view, as Sorter has it, to `order`, which has room for all splats.
  /// Returns how many are listed. Allocates nothing.
  std::uint32_t sort(const SortView& view, std::span<std::uint32_t> order);

 private:
  std::vector<glm::vec3> positions_;
  std::vector<std::uint32_t> keys_;
  RadixScratch scratch_;
};

}  // namespace fluxgs::sort
