#include "codec/rotations.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "fluxgs/math/projection.h"

namespace fluxgs::codec {

glm::vec3 reduced_rotation(const glm::quat& rotation) {
  const auto q =
      math::normalized(math::Quat<double>{rotation.w, rotation.x, rotation.y, rotation.z});
  // q·1, q·i, q·j, q·k
  const std::array<std::array<double, 4>, 4> same{{{q.w, q.x, q.y, q.z},
                                                   {-q.x, q.w, q.z, -q.y},
                                                   {-q.y, -q.z, q.w, q.x},
                                                   {-q.z, q.y, -q.x, q.w}}};
  const auto& best = *std::ranges::max_element(
      same, {}, [](const std::array<double, 4>& r) { return std::abs(r[0]); });
  const double sign = best[0] < 0 ? -1 : 1;
  return {sign * best[1], sign * best[2], sign * best[3]};
}

glm::quat full_rotation(const glm::vec3& xyz) {
  const float square = xyz.x * xyz.x + xyz.y * xyz.y + xyz.z * xyz.z;
  if (square < 1) return glm::quat(std::sqrt(1 - square), xyz.x, xyz.y, xyz.z);
  return glm::normalize(glm::quat(0, xyz.x, xyz.y, xyz.z));
}

}  // namespace fluxgs::codec
