#include "trainer/compress/sh_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <glm/geometric.hpp>

#include "fluxgs/math/spherical_harmonics.h"

namespace fluxgs {
namespace {

using ShVector = Eigen::Matrix<double, kShCount, 1>;

ShVector basis_at(const glm::dvec3& d) {
  ShVector y;
  y[0] = math::kSh0;
  math::sh_basis(3, math::Vec3<double>{d.x, d.y, d.z}, y.data() + 1);
  return y;
}

/// Adds a direction; the Gram matrix stays a sum until it is divided by the weight.
void add(SplatViews& views, double weight, const glm::dvec3& direction) {
  const ShVector y = basis_at(direction);
  views.weight += weight;
  views.gram.noalias() += (weight * y) * y.transpose();
}

template <int n>
Eigen::Matrix<double, n, n> normal_matrix(const SplatViews& views, double prior) {
  return views.gram.topLeftCorner<n, n>() +
         prior / (4 * std::numbers::pi) * Eigen::Matrix<double, n, n>::Identity();
}

template <int n>
void fit(const SplatViews& views, double prior, ShCoefficients& c) {
  const Eigen::Matrix<double, n, 3> seen =
      views.gram.topRightCorner<n, kShCount - n>() * c.bottomRows<kShCount - n>();
  c.topRows<n>() += normal_matrix<n>(views, prior).ldlt().solve(seen);
}

template <int n>
double left_out(const SplatViews& views, const std::vector<WeightedDirection>& directions,
                const ShCoefficients& difference, double prior) {
  const Eigen::LDLT<Eigen::Matrix<double, n, n>> normal(normal_matrix<n>(views, prior));
  double sum = 0;
  for (const auto& [weight, direction] : directions) {
    const ShVector y = basis_at(direction);
    const double part = weight / views.weight;
    const double leverage = part * y.head<n>().dot(normal.solve(y.head<n>()));
    sum += part * ((difference.transpose() * y) / (1 - leverage)).squaredNorm();
  }
  return sum;
}

}  // namespace

std::vector<WeightedDirection> directions_of(const ViewWeights& views,
                                             const PlanarFloats& parameters, std::size_t i) {
  const glm::dvec3 position(parameters.row(row::position)[i], parameters.row(row::position + 1)[i],
                            parameters.row(row::position + 2)[i]);
  std::vector<WeightedDirection> directions;
  for (int v = 0; v < views.weights.rows(); ++v) {
    const double weight = views.weights.row(v)[i];
    const glm::dvec3 ray = position - views.centers[static_cast<std::size_t>(v)];
    const double length = glm::length(ray);
    if (!(weight > 0 && std::isfinite(weight) && length > 0 && std::isfinite(length))) continue;
    directions.push_back({weight, ray / length});
  }
  return directions;
}

SplatViews views_along(const std::vector<WeightedDirection>& directions) {
  SplatViews result;
  for (const auto& [weight, direction] : directions) add(result, weight, direction);
  if (result.weight > 0) result.gram /= result.weight;
  return result;
}

SplatViews splat_views(const ViewWeights& views, const PlanarFloats& parameters, std::size_t i) {
  return views_along(directions_of(views, parameters, i));
}

SplatViews sphere_views(const SphereRule& rule) {
  SplatViews result;
  for (std::size_t k = 0; k < rule.directions.size(); ++k)
    add(result, rule.weights[k], rule.directions[k]);
  result.gram /= result.weight;
  return result;
}

ShCoefficients sh_coefficients(const PlanarFloats& parameters, std::size_t i) {
  ShCoefficients c = ShCoefficients::Zero();
  for (int r = row::sh_dc; r < parameters.rows(); ++r)
    c((r - row::sh_dc) / 3, (r - row::sh_dc) % 3) = double{parameters.row(r)[i]};
  return c;
}

ShCoefficients truncated(const ShCoefficients& c, int degree) {
  ShCoefficients low = c;
  low.bottomRows(kShCount - (degree + 1) * (degree + 1)).setZero();
  return low;
}

ShCoefficients fit_degree(const SplatViews& views, const ShCoefficients& c, int degree,
                          double prior) {
  ShCoefficients fitted = c;
  if (views.weight > 0) {
    if (degree == 0) fit<1>(views, prior, fitted);
    if (degree == 1) fit<4>(views, prior, fitted);
    if (degree == 2) fit<9>(views, prior, fitted);
  }
  return truncated(fitted, degree);
}

double square_error(const SplatViews& views, const ShCoefficients& a, const ShCoefficients& b) {
  const ShCoefficients difference = a - b;
  double sum = 0;
  for (int c = 0; c < 3; ++c) sum += difference.col(c).dot(views.gram * difference.col(c));
  return std::max(0.0, sum);  // rounding may leave less than nothing
}

double left_out_error(const SplatViews& views, const std::vector<WeightedDirection>& directions,
                      const ShCoefficients& c, int degree, double prior) {
  const ShCoefficients difference = c - fit_degree(views, c, degree, prior);
  if (degree == 0) return left_out<1>(views, directions, difference, prior);
  if (degree == 1) return left_out<4>(views, directions, difference, prior);
  if (degree == 2) return left_out<9>(views, directions, difference, prior);
  return 0;
}

}  // namespace fluxgs
