#include "trainer/compress/fit_splats.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "trainer/compress/sh_fit.h"

namespace fluxgs {
namespace {

constexpr std::size_t kFitPiece = 256;  // splats per piece of parallel work
constexpr double kLargest = std::numeric_limits<float>::max();

/// Calls work(i) for every splat, in parallel.
template <class Work>
void for_splats(std::size_t size, const Threads& threads, const Work& work) {
  threads.for_pieces(size, kFitPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) work(i);
  });
}

PlanarFloats without_colors(const PlanarFloats& parameters) {
  PlanarFloats rows(parameters.rows(), parameters.size());
  for (int r = 0; r < row::sh_dc; ++r)
    std::copy_n(parameters.row(r), parameters.size(), rows.row(r));
  return rows;
}

/// The largest float for what is beyond it.
float to_float(double x) { return static_cast<float>(std::min(x, kLargest)); }

void store(const ShCoefficients& c, std::size_t i, PlanarFloats& parameters) {
  for (int r = row::sh_dc; r < parameters.rows(); ++r)
    parameters.row(r)[i] = static_cast<float>(c((r - row::sh_dc) / 3, (r - row::sh_dc) % 3));
}

/// Fits splat i, with the views that see(i) returns, to degree_of(i).
template <class See, class DegreeOf>
PlanarFloats fit_all(const PlanarFloats& parameters, double prior, const Threads& threads,
                     const DegreeOf& degree_of, const See& see) {
  PlanarFloats result = without_colors(parameters);
  for_splats(parameters.size(), threads, [&](std::size_t i) {
    const ShCoefficients c = sh_coefficients(parameters, i);
    const int degree = degree_of(i);
    ShCoefficients fitted = truncated(c, degree);
    if (!c.allFinite())
      fitted.row(0).setConstant(std::numeric_limits<double>::quiet_NaN());
    else if (degree < 3)
      fitted = fit_degree(see(i), c, degree, prior);
    // Colours near the largest float: the fit may be beyond it
    if (fitted.cwiseAbs().maxCoeff() > kLargest) fitted = truncated(c, degree);
    store(fitted, i, result);
  });
  return result;
}

}  // namespace

PlanarFloats rows_of_degree(const PlanarFloats& rows, int degree) {
  PlanarFloats result(row::count(degree), rows.size());
  for (int r = 0; r < result.rows(); ++r) std::copy_n(rows.row(r), rows.size(), result.row(r));
  return result;
}

PlanarFloats fit_to_views(const PlanarFloats& parameters, const std::vector<std::uint8_t>& degrees,
                          const ViewWeights& views, double prior, const Threads& threads) {
  return fit_all(
      parameters, prior, threads, [&](std::size_t i) { return int{degrees[i]}; },
      [&](std::size_t i) { return splat_views(views, parameters, i); });
}

PlanarFloats fit_to_views(const PlanarFloats& parameters, int degree, const ViewWeights& views,
                          double prior, const Threads& threads) {
  const PlanarFloats fitted = fit_all(
      parameters, prior, threads, [&](std::size_t) { return degree; },
      [&](std::size_t i) { return splat_views(views, parameters, i); });
  return rows_of_degree(fitted, degree);
}

PlanarFloats fit_to_sphere(const PlanarFloats& parameters, int degree, const SphereRule& rule,
                           const Threads& threads) {
  const SplatViews sphere = sphere_views(rule);
  // The prior matters only to rules of fewer directions than there are functions
  const PlanarFloats fitted = fit_all(
      parameters, kSpherePrior, threads, [&](std::size_t) { return degree; },
      [&](std::size_t) -> const SplatViews& { return sphere; });
  return rows_of_degree(fitted, degree);
}

Unexplained unexplained_variance(const PlanarFloats& parameters, const ViewWeights& views,
                                 double prior, const Threads& threads) {
  const std::size_t size = parameters.size();
  Unexplained result{std::vector<float>(size), PlanarFloats(4, size), PlanarFloats(4, size)};
  for_splats(size, threads, [&](std::size_t i) {
    const ShCoefficients c = sh_coefficients(parameters, i);
    if (!c.allFinite()) return;
    const SplatViews seen = splat_views(views, parameters, i);
    result.weights[i] = to_float(seen.weight);
    for (int d = 0; d < 3; ++d) {
      result.truncated.row(d)[i] = to_float(square_error(seen, c, truncated(c, d)));
      result.fitted.row(d)[i] = to_float(square_error(seen, c, fit_degree(seen, c, d, prior)));
    }
  });
  return result;
}

}  // namespace fluxgs
