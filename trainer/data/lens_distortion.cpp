#include "trainer/data/lens_distortion.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <glm/matrix.hpp>

namespace fluxgs {
namespace {

using glm::dvec2;
using Coefficients = decltype(Lens::distortion);

dvec2 perspective(const Coefficients& k, const dvec2& p) {
  const double r2 = glm::dot(p, p);
  const double radial =
      (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
  return {p.x * radial + 2 * k[2] * p.x * p.y + k[3] * (r2 + 2 * p.x * p.x),
          p.y * radial + k[2] * (r2 + 2 * p.y * p.y) + 2 * k[3] * p.x * p.y};
}

/// The ray at its angle from the axis: |result| = atan |p|.
dvec2 equidistant(const dvec2& p) {
  const double r = glm::length(p);
  return r < 1e-8 ? p : p * (std::atan(r) / r);
}

dvec2 fisheye(const Coefficients& k, const dvec2& p) {
  const dvec2 e = equidistant(p);
  const double t2 = glm::dot(e, e);
  return e * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}

dvec2 field_of_view(double omega, const dvec2& p) {
  const double r = glm::length(p);
  if (std::abs(omega) < 1e-6) return p;
  const double slope = 2 * std::tan(omega / 2);
  return r < 1e-8 ? p * (slope / omega) : p * (std::atan(r * slope) / (r * omega));
}

std::optional<dvec2> division(double k, const dvec2& p) {
  const double root = 1 - 4 * k * glm::dot(p, p);
  if (root < 0) return std::nullopt;
  return p * (2 / (1 + std::sqrt(root)));
}

std::optional<dvec2> eucm(double alpha, double beta, const dvec2& p) {
  const double depth = alpha * std::sqrt(beta * glm::dot(p, p) + 1) + 1 - alpha;
  if (!(depth > 0)) return std::nullopt;
  return p / depth;
}

// k1 k2 p1 p2 k3 k4 sx1 sy1
dvec2 thin_prism_fisheye(const Coefficients& k, const dvec2& p) {
  const dvec2 e = equidistant(p);
  const double t2 = glm::dot(e, e), xy = e.x * e.y;
  const double radial = t2 * (k[0] + t2 * (k[1] + t2 * (k[4] + t2 * k[5])));
  return e + e * radial +
         dvec2(2 * k[2] * xy + k[3] * (t2 + 2 * e.x * e.x) + k[6] * t2,
               k[2] * (t2 + 2 * e.y * e.y) + 2 * k[3] * xy + k[7] * t2);
}

// k0 … k5 p0 p1 s0 … s3
dvec2 rad_tan_thin_prism_fisheye(const Coefficients& k, const dvec2& p) {
  const dvec2 e = equidistant(p);
  const double t2 = glm::dot(e, e);
  double radial = 0;
  for (std::size_t i = 6; i-- > 0;) radial = t2 * (k[i] + radial);
  const dvec2 r = e * (1 + radial), tangential(k[6], k[7]);
  const double r2 = glm::dot(r, r);
  return r + r * (2 * glm::dot(r, tangential)) + tangential * r2 +
         dvec2(r2 * (k[8] + r2 * k[9]), r2 * (k[10] + r2 * k[11]));
}

/// ∂distort/∂ray by central differences. Nothing where it has no value.
std::optional<glm::dmat2> derivative(const Lens& lens, const dvec2& ray) {
  const double h = 1e-6 * (1 + glm::length(ray));
  glm::dmat2 columns;
  for (int axis = 0; axis < 2; ++axis) {
    dvec2 step(0.0);
    step[axis] = h;
    const auto more = distort(lens, ray + step), less = distort(lens, ray - step);
    if (!more || !less) return std::nullopt;
    columns[axis] = (*more - *less) / (2 * h);
  }
  return columns;
}

enum class Newton { found, folded, too_wide };

/// Solves distort(ray) = place from a ray nearby, which is replaced if that succeeds.
Newton solve(const Lens& lens, const dvec2& place, dvec2& ray) {
  dvec2 r = ray;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const auto at = distort(lens, r);
    const auto slope = derivative(lens, r);
    // Monotone is: no axis is turned around
    if (!at || !slope || !(glm::determinant(*slope) > 0)) return Newton::folded;
    const dvec2 miss = place - *at;
    if (glm::length(miss) < 1e-11 * (1 + glm::length(place))) {
      ray = r;
      return Newton::found;
    }
    r += glm::inverse(*slope) * miss;
    if (!(glm::length(r) < kMaxRay))
      return std::isfinite(r.x + r.y) ? Newton::too_wide : Newton::folded;
  }
  return Newton::folded;
}

}  // namespace

std::optional<dvec2> distort(const Lens& lens, const dvec2& ray) {
  const Coefficients& k = lens.distortion;
  switch (lens.model) {
    case LensModel::kPerspective:
      return perspective(k, ray);
    case LensModel::kFisheye:
      return fisheye(k, ray);
    case LensModel::kFieldOfView:
      return field_of_view(k[0], ray);
    case LensModel::kDivision:
      return division(k[0], ray);
    case LensModel::kEucm:
      return eucm(k[0], k[1], ray);
    case LensModel::kThinPrismFisheye:
      return thin_prism_fisheye(k, ray);
    case LensModel::kRadTanThinPrismFisheye:
      return rad_tan_thin_prism_fisheye(k, ray);
  }
  return std::nullopt;
}

RayOfPlace undistort(const Lens& lens, const dvec2& place) {
  RayOfPlace result;
  double done = 0, step = 1.0 / 16;
  while (done < 1) {
    const double next = std::min(done + step, 1.0);
    const Newton solved = solve(lens, place * next, result.ray);
    if (solved == Newton::found) {
      done = next;
      continue;
    }
    step /= 2;
    if (step < 1e-5) {
      result.folded = solved == Newton::folded;
      return result;
    }
  }
  result.reached = true;
  return result;
}

}  // namespace fluxgs
