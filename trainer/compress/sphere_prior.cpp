#include "trainer/compress/sphere_prior.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

#include "trainer/compress/sh_fit.h"

namespace fluxgs {
namespace {

constexpr std::size_t kMaxSplats = 4096;
constexpr std::size_t kPriorPiece = 64;  // splats per piece of parallel work

double loss_of(const PlanarFloats& parameters, const ViewWeights& views, std::size_t i,
               double prior) {
  const ShCoefficients c = sh_coefficients(parameters, i);
  if (!c.allFinite()) return 0;
  const std::vector<WeightedDirection> directions = directions_of(views, parameters, i);
  const SplatViews seen = views_along(directions);
  double sum = 0;
  for (int degree = 0; degree < 3; ++degree)
    sum += left_out_error(seen, directions, c, degree, prior);
  return seen.weight * sum;
}

}  // namespace

double left_out_loss(const PlanarFloats& parameters, const ViewWeights& views, double prior,
                     const Threads& threads) {
  const std::size_t stride = parameters.size() / kMaxSplats + 1;
  std::vector<double> losses((parameters.size() + stride - 1) / stride);
  threads.for_pieces(losses.size(), kPriorPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      losses[k] = loss_of(parameters, views, k * stride, prior);
  });
  return std::accumulate(losses.begin(), losses.end(), 0.0);
}

double best_sphere_prior(const PlanarFloats& parameters, const ViewWeights& views,
                         const Threads& threads) {
  std::vector<double> losses;
  for (const double prior : kSpherePriors)
    losses.push_back(left_out_loss(parameters, views, prior, threads));
  return kSpherePriors[std::ranges::min_element(losses) - losses.begin()];
}

}  // namespace fluxgs
