#include "trainer/densify/splat_scores.h"

#include <algorithm>

#include "trainer/densify/metric_maps.h"
#include "trainer/loss/photometric.h"

namespace fluxgs {
namespace {

void add(const float* row, std::vector<float>& sums) {
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += row[i];
}

}  // namespace

SplatScores score_splats(const std::vector<View>& views, const std::vector<std::uint32_t>& sampled,
                         const PlanarFloats& parameters, const RenderOptions& render,
                         const TrainOptions& options, Rasterizer& rasterizer,
                         const Threads& threads) {
  const std::size_t count = parameters.size();
  SplatScores scores;
  for (auto* sums : {&scores.plus, &scores.minus, &scores.contribution, &scores.pixels})
    sums->resize(count);
  PlanarImage target;
  for (const std::uint32_t index : sampled) {
    const View& view = views[index];
    rasterizer.forward(parameters, view.camera, render);
    to_planar(view.rgb, threads, target);
    const PlanarImage loss =
        loss_map(rasterizer.color(), target, options.score_loss, options.lambda_dssim);
    const PlanarFloats& sums = rasterizer.score(metric_maps(loss, options), options.score_weight);
    add(sums.row(score::first), scores.plus);
    add(sums.row(score::second), scores.minus);
    add(sums.row(score::contribution), scores.contribution);
    add(sums.row(score::pixels), scores.pixels);
  }
  if (options.score_share == ScoreShare::pixel)
    for (std::size_t i = 0; i < count; ++i) {
      scores.plus[i] /= std::max(scores.pixels[i], 1.0f);
      scores.minus[i] /= std::max(scores.pixels[i], 1.0f);
    }
  return scores;
}

float score_quantile(const std::vector<float>& values, const SplatScores& scores, double quantile,
                     ScoreShare share) {
  std::vector<float> counted;
  counted.reserve(values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    if (share == ScoreShare::sum || scores.pixels[i] > 0) counted.push_back(values[i]);
  if (counted.empty()) return -1;
  const auto at = counted.begin() +
                  static_cast<std::ptrdiff_t>(quantile * static_cast<double>(counted.size() - 1));
  std::nth_element(counted.begin(), at, counted.end());
  return *at;
}

}  // namespace fluxgs
