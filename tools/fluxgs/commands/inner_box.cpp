#include "tools/fluxgs/commands/inner_box.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace fluxgs::cli {

Box inner_box(const SplatCloud& cloud) {
  Box box;
  if (cloud.size() == 0) return box;
  const std::size_t edge = cloud.size() / 100;
  std::vector<float> values(cloud.size());
  for (int c = 0; c < 3; ++c) {
    std::ranges::transform(cloud.positions, values.begin(),
                           [c](const glm::vec3& p) { return p[c]; });
    const auto at = [&](std::size_t rank) {
      const auto place = values.begin() + static_cast<std::ptrdiff_t>(rank);
      std::ranges::nth_element(values, place);
      return static_cast<double>(*place);
    };
    box.min[c] = at(edge);
    box.max[c] = at(cloud.size() - 1 - edge);
  }
  return box;
}

}  // namespace fluxgs::cli
