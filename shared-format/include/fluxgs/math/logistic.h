// The logistic function and its inverse: opacities are trained and stored as logits.
#pragma once

#include <cmath>

namespace fluxgs {

/// 0…1 of −∞…∞.
template <class Scalar>
Scalar sigmoid(Scalar logit) {
  return 1 / (1 + std::exp(-logit));
}

/// The other way round.
template <class Scalar>
Scalar logit(Scalar probability) {
  return std::log(probability / (1 - probability));
}

}  // namespace fluxgs
