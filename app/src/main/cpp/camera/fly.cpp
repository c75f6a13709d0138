#include "camera/fly.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace fluxgs::camera {

ViewState fly(const ViewState& view, const FlyDirection& direction, double speed, double seconds,
              const glm::dvec3& up) {
  const glm::dvec3 way =
      direction.right * right(view) + direction.up * up + direction.forward * forward(view);
  ViewState result = view;
  result.target += way * (speed * seconds / std::max(glm::length(way), 1.0));
  return result;
}

}  // namespace fluxgs::camera
