#include "trainer/raster/blend_weights.h"

#include <algorithm>

#include "fluxgs/math/spherical_harmonics.h"

namespace fluxgs {
namespace {

/// A picture's sum depends on a splat's red coefficient by c₀·Σ α·T, as long as no colour is cut
/// off at zero: all of them become the grey of coefficients 0, or NaN where they were not finite.
PlanarFloats without_colors(const PlanarFloats& parameters) {
  PlanarFloats grey(row::count(0), parameters.size());
  for (int r = 0; r < row::sh_dc; ++r)
    std::copy_n(parameters.row(r), parameters.size(), grey.row(r));
  float* red = grey.row(row::sh_dc);
  for (int r = row::sh_dc; r < parameters.rows(); ++r) {
    const float* from = parameters.row(r);
    for (std::size_t i = 0; i < parameters.size(); ++i) red[i] += from[i] - from[i];
  }
  return grey;
}

}  // namespace

BlendWeights::BlendWeights(const PlanarFloats& parameters, const RenderOptions& options,
                           const Threads& threads)
    : grey_(without_colors(parameters)),
      options_(options),
      rasterizer_(make_cpu_rasterizer(threads, times_)),
      weights_(parameters.size()) {}

const std::vector<float>& BlendWeights::of(const Camera& camera) {
  rasterizer_->forward(grey_, camera, options_);
  PlanarImage ones(camera.width, camera.height, 3);
  for (int y = 0; y < camera.height; ++y) std::fill_n(ones.row(0, y), camera.width, 1.0f);
  rasterizer_->backward(grey_, ones);
  const float* red = rasterizer_->gradient().row(row::sh_dc);
  for (std::size_t i = 0; i < weights_.size(); ++i)
    weights_[i] = rasterizer_->visible()[i] ? static_cast<float>(double{red[i]} / math::kSh0) : 0;
  return weights_;
}

}  // namespace fluxgs
