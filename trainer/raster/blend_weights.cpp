#include "trainer/raster/blend_weights.h"

namespace fluxgs {

BlendWeights::BlendWeights(const PlanarFloats& parameters, const RenderOptions& options,
                           const Threads& threads)
    : parameters_(parameters),
      options_(options),
      rasterizer_(make_cpu_rasterizer(threads, profiler_)),
      weights_(parameters.size()),
      pixels_(parameters.size()) {}

const std::vector<float>& BlendWeights::of(const Camera& camera, const Image<std::uint8_t>& used) {
  rasterizer_->forward(parameters_, camera, options_);
  PlanarImage no_maps(camera.width, camera.height, used.pixels.empty() ? 2 : 3);
  if (!used.pixels.empty()) copy_mask(used, no_maps, 2);
  const PlanarFloats& scores = rasterizer_->score(no_maps, ScoreWeight::alpha_transmittance);
  const auto copy = [&](int row, std::vector<float>& to) {
    to.assign(scores.row(row), scores.row(row) + parameters_.size());
  };
  copy(score::contribution, weights_);
  copy(score::pixels, pixels_);
  return weights_;
}

}  // namespace fluxgs
