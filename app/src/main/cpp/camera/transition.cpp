#include "camera/transition.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

namespace fluxgs::camera {

ViewState between(const ViewState& from, const ViewState& to, double part) {
  const double t = std::clamp(part, 0.0, 1.0);
  if (t >= 1) return to;
  const double s = t * t * t * (10 + t * (6 * t - 15));  // without a jerk at either end
  ViewState view;
  view.target = glm::mix(from.target, to.target, s);
  view.orientation = glm::normalize(glm::slerp(from.orientation, to.orientation, s));
  view.distance = std::exp(glm::mix(std::log(from.distance), std::log(to.distance), s));
  view.fov = glm::mix(from.fov, to.fov, s);
  return view;
}

bool finished(const Transition& transition) { return transition.elapsed >= transition.seconds; }

ViewState advance(Transition& transition, double seconds) {
  transition.elapsed += std::max(seconds, 0.0);
  if (finished(transition)) return transition.to;
  return between(transition.from, transition.to, transition.elapsed / transition.seconds);
}

}  // namespace fluxgs::camera
