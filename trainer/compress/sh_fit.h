// The SH coefficients of a lower degree that look most like given ones, from where a splat is seen.
//
// For the directions d_v with weights w_v (W = Σ w_v), the coefficients a of the lower degree
// minimise, for each colour channel,
//
//   Σ (w_v/W)·(c(d_v) − a(d_v))² + prior·(1/4π)∫(c − a)² dω,
//
// the square error over the views and, a little, over the whole sphere. Over the sphere alone the
// solution is truncation, because the basis is orthonormal: the second term is (prior/4π)·|δ|² and
// a constant, with δ = a − truncated c. With the mean Gram matrix G = Σ (w_v/W)·y(d_v)·y(d_v)ᵀ of
// the basis functions, split into those kept (l) and dropped (h), that is
//
//   (G_ll + prior/4π·I)·δ = G_lh·c_h.
//
// The prior has no scale: trace G_ll = n/4π for n functions whatever the directions are (addition
// theorem), so it is prior/n of the trace. Views that span few directions (none, one, a line of
// cameras) leave the rest of δ at its smallest, zero where nothing is seen at all; and always
// |δ|/√4π, the root mean square change over the sphere, is at most 1/(2√prior) times that of the
// dropped bands over the views.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <glm/vec3.hpp>

#include "trainer/compress/view_weights.h"
#include "trainer/core/quadrature.h"

namespace fluxgs {

inline constexpr int kShCount = 16;  ///< functions of degree 3 or less, the constant one first
using ShGram = Eigen::Matrix<double, kShCount, kShCount>;
using ShCoefficients = Eigen::Matrix<double, kShCount, 3>;  ///< columns: red, green, blue

/// Views of a splat.
struct SplatViews {
  double weight = 0;             ///< W; 0: not seen
  ShGram gram = ShGram::Zero();  ///< G; its trace is 16/4π, or 0 where the splat is not seen
};

/// A direction from a camera to a splat.
struct WeightedDirection {
  double weight;
  glm::dvec3 direction;
};

/// Those of splat i. Weights that are not positive and finite, and cameras in whose centre the
/// splat lies, do not count.
std::vector<WeightedDirection> directions_of(const ViewWeights& views,
                                             const PlanarFloats& parameters, std::size_t i);

SplatViews views_along(const std::vector<WeightedDirection>& directions);

/// views_along(directions_of(…)).
SplatViews splat_views(const ViewWeights& views, const PlanarFloats& parameters, std::size_t i);

/// The whole sphere by a rule's directions: G is I/4π where the rule is exact for products of two
/// basis functions.
SplatViews sphere_views(const SphereRule& rule);

/// All coefficients of splat i; zeros where `parameters` have fewer.
ShCoefficients sh_coefficients(const PlanarFloats& parameters, std::size_t i);

/// The coefficients of degree `degree` (0…3), zeros beyond; `prior` > 0. Finite for finite `c` in
/// the range of a float.
ShCoefficients fit_degree(const SplatViews& views, const ShCoefficients& c, int degree,
                          double prior);

/// `c` without the bands above a degree.
ShCoefficients truncated(const ShCoefficients& c, int degree);

/// Σ (w_v/W)·|a(d_v) − b(d_v)|², the channels added up.
double square_error(const SplatViews& views, const ShCoefficients& a, const ShCoefficients& b);

/// Σ (w_v/W)·|c(d_v) − a(d_v)|², the channels added up, where a is fitted, with W and `prior` the
/// same, to all `directions` but d_v. `views`: of these directions; `prior` > 0. As the fit is
/// linear in its data, that difference is the one with v taken into the fit, over 1 −
/// (w_v/W)·yᵀ·N⁻¹·y with the normal matrix N (Allen 1974, PRESS).
double left_out_error(const SplatViews& views, const std::vector<WeightedDirection>& directions,
                      const ShCoefficients& c, int degree, double prior);

}  // namespace fluxgs
