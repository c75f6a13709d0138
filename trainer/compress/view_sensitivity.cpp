#include "trainer/compress/view_sensitivity.h"

#include <cstddef>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>

#include "trainer/compress/sh_fit.h"
#include "trainer/compress/shape_hessian.h"
#include "trainer/data/dataset.h"

namespace fluxgs {
namespace {

constexpr std::size_t kSensitivityPiece = 256;  // splats per piece of parallel work

/// Views that span few directions leave a Gram matrix that is not positive definite, which the
/// sphere mends. Alone it makes the identity.
ShGram factor_of(const SplatViews& views) {
  ShGram weighted = ShGram::Identity();
  if (views.weight > 0)
    weighted = 4 * std::numbers::pi * views.gram + kSphereShare * ShGram::Identity();
  return weighted.llt().matrixL();
}

}  // namespace

std::vector<float> total_weights(const ViewWeights& views) {
  std::vector<double> sums(views.weights.size());
  for (int v = 0; v < views.weights.rows(); ++v)
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += double{views.weights.row(v)[i]};
  return {sums.begin(), sums.end()};
}

std::vector<float> sh_factors(const PlanarFloats& parameters, const ViewWeights& views,
                              const Threads& threads) {
  const int degree = sh_degree_of(parameters);
  const std::size_t each = sh_factor_size(degree);
  std::vector<float> result(each * parameters.size());
  threads.for_pieces(parameters.size(), kSensitivityPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const ShGram factor = factor_of(splat_views(views, parameters, i));
      float* to = &result[i * each];
      for (int row = 0; row <= sh_rest_count(degree); ++row)
        for (int column = 0; column <= row; ++column)
          *to++ = static_cast<float>(factor(row, column));
    }
  });
  return result;
}

SensitivityWeights view_sensitivity(const std::vector<Camera>& all, const SplatCloud& cloud,
                                    bool has_networks, const RenderOptions& asked,
                                    const Threads& threads, const WorkControl& control) {
  const RenderOptions render = for_scene(asked, cloud.filter);
  const PlanarFloats parameters = to_parameters(cloud, cloud.sh_degree);
  const std::vector<Camera> cameras = spread_cameras(all, kSensitivityViews);
  const ProgressParts parts(control.progress, {1, has_networks ? 0.0 : 4.0});
  const ViewWeights views =
      view_weights(parameters, cameras, render, threads, {parts.part(0), control.stop});
  SensitivityWeights sensitivity{.weights = total_weights(views)};
  if (has_networks) return sensitivity;
  sensitivity.sh_factors = sh_factors(parameters, views, threads);
  ShapeHessian hessian =
      shape_hessian(parameters, cameras, render, threads, {parts.part(1), control.stop});
  sensitivity.scale = std::move(hessian.scale);
  sensitivity.rotation = std::move(hessian.rotation);
  return sensitivity;
}

}  // namespace fluxgs
