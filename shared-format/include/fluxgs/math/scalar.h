// Functions that formulas need of a scalar type T: float, double, or a pack of SIMD lanes that
// brings its own overloads of these functions (found by argument-dependent lookup).
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>

namespace fluxgs::math {

/// `yes` where the condition holds, `no` elsewhere.
template <std::floating_point T>
T select(bool condition, T yes, T no) {
  return condition ? yes : no;
}

/// The larger one; b if a is NaN.
// max(NaN, b) must be the same everywhere; std::max depends on the order of its arguments.
template <std::floating_point T>
T max(T a, T b) {
  return a > b ? a : b;
}
/// The smaller one; b if a is NaN.
template <std::floating_point T>
T min(T a, T b) {
  return a < b ? a : b;
}
/// |a|
template <std::floating_point T>
T abs(T a) {
  return std::fabs(a);
}
/// √a
template <std::floating_point T>
T sqrt(T a) {
  return std::sqrt(a);
}
/// eᵃ
template <std::floating_point T>
T exp(T a) {
  return std::exp(a);
}

}  // namespace fluxgs::math
