#include "fluxgs/contribution.h"

#include <cmath>

#include "fluxgs/math/logistic.h"

namespace fluxgs {

double contribution(const SplatCloud& cloud, std::size_t i) {
  const glm::dvec3 s = glm::exp(glm::dvec3(cloud.log_scales[i]));
  const double opacity = sigmoid(double{cloud.opacity_logits[i]});
  const double value = opacity * (s.x * s.y + s.y * s.z + s.z * s.x) / 3;
  return std::isnan(value) ? 0 : value;
}

}  // namespace fluxgs
