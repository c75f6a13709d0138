// Rotating spherical harmonics: the matrices that act on the coefficients of each degree (Wigner's
// D-matrices for the real basis of spherical_harmonics.h).
#pragma once

#include <array>

#include <glm/vec3.hpp>

#include "fluxgs/math/vec.h"

namespace fluxgs::math {

/// One (2l+1)×(2l+1) matrix per degree l = 1, 2, 3, row-major.
struct ShRotation {
  std::array<double, 9> degree1;   ///< 3×3
  std::array<double, 25> degree2;  ///< 5×5
  std::array<double, 49> degree3;  ///< 7×7
};

/// The matrices of a rotation R (orthonormal, determinant +1): rotating coefficients c to c′ turns
/// the function on the sphere with the scene, Σ c′ᵢ·Yᵢ(d) = Σ cᵢ·Yᵢ(R⁻¹·d).
ShRotation make_sh_rotation(const Mat3<double>& rotation);

/// Rotate the sh_rest_count(degree) RGB coefficients of one splat in place.
void rotate_sh(const ShRotation& rotation, int degree, glm::vec3* coefficients);

}  // namespace fluxgs::math
