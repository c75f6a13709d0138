#include "camera/drift.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace fluxgs::camera {
namespace {

constexpr double kEaseIn = 2;    // seconds to full speed
constexpr double kSwing = 0.35;  // radians to either side
constexpr double kMiddle = 0.5;  // of the scene's radius: targets within are about its middle

/// The angle of a drift so far: the integral of a speed that rises as 3u² − 2u³.
double turned_by(const Drift& drift) {
  const double u = std::min(drift.elapsed / kEaseIn, 1.0);
  const double way =
      kDriftSpeed * (kEaseIn * u * u * u * (1 - 0.5 * u) + std::max(drift.elapsed - kEaseIn, 0.0));
  return drift.farthest > 0 ? drift.farthest * std::sin(way / drift.farthest) : way;
}

}  // namespace

Drift drift_from(const ViewState& view, const SceneUnits& units) {
  const bool outside = glm::distance(eye(view), units.center) > units.radius;
  const bool about_middle = glm::distance(view.target, units.center) < kMiddle * units.radius;
  return {.farthest = outside || about_middle ? 0 : kSwing};
}

ViewState advance(Drift& drift, double seconds, const ViewState& view, const glm::dvec3& up) {
  const double before = turned_by(drift);
  drift.elapsed += std::max(seconds, 0.0);
  ViewState result = view;
  result.orientation =
      glm::normalize(glm::angleAxis(turned_by(drift) - before, up) * view.orientation);
  return result;
}

}  // namespace fluxgs::camera
