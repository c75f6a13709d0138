#include "io/splat/spatial_order.h"

#include <algorithm>
#include <cmath>

#include "fluxgs/morton.h"
#include "io/splat/scene_core.h"

namespace fluxgs::io {

std::vector<std::uint32_t> spatial_order(const std::vector<glm::vec3>& positions) {
  if (positions.empty()) return {};
  const SceneCore core = scene_core(positions);
  const double radius = std::max(core.radius, 1e-30);
  std::vector<glm::vec3> contracted(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const double x = (positions[i][c] - core.center[c]) / radius;
      contracted[i][c] = static_cast<float>(std::copysign(std::log1p(std::abs(x)), x));
    }
  }
  return morton_order(contracted);
}

}  // namespace fluxgs::io
