#include "trainer/data/middle.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "trainer/core/median.h"

namespace fluxgs {

Middle middle_of(const std::vector<glm::dvec3>& positions) {
  Middle middle;
  std::vector<double> values(positions.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(positions, values.begin(), [&](const auto& p) { return p[axis]; });
    middle.centre[axis] = *median(values);
  }
  std::ranges::transform(positions, values.begin(),
                         [&](const auto& p) { return glm::distance(p, middle.centre); });
  middle.radius = *median(values);
  return middle;
}

}  // namespace fluxgs
