#include "trainer/densify/splat_scores.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "trainer/data/photo_memory.h"
#include "trainer/densify/metric_maps.h"
#include "trainer/loss/photometric.h"

namespace fluxgs {
namespace {

void add(const float* row, std::vector<float>& sums) {
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += row[i];
}

/// Root mean square of a loss over pixels that count.
class RmsLoss {
 public:
  void add(const PlanarImage& loss, const Image<std::uint8_t>& used) {
    for (int y = 0; y < loss.height(); ++y)
      for (int x = 0; x < loss.width(); ++x) {
        const float l = loss.row(0, y)[x];
        if (!std::isfinite(l) || (!used.pixels.empty() && *used.at(x, y) == 0)) continue;
        squares_ += double{l} * double{l};
        ++pixels_;
      }
  }
  double value() const {
    return std::sqrt(squares_ / static_cast<double>(std::max(pixels_, std::uint64_t{1})));
  }

 private:
  double squares_ = 0;
  std::uint64_t pixels_ = 0;
};

}  // namespace

OptionFields ScoreOptions::fields(const TrainOptions&) {
  const bool used = uses_plus || uses_minus;
  const char* any = "--densify multiview, --prune multiview or --late-prune opacity";
  const char* pruning = "--prune multiview or --late-prune opacity";
  const bool stratified = used && sampling == CameraSampling::stratified;
  const char* bins = "multi-view scores with --camera-sampling stratified";
  return {
      whole("score-views", "views that scores are taken from", views, 1, 1000).only_if(used, any),
      choice("camera-sampling", "choice of these views", sampling, kCameraSamplingNames)
          .only_if(used, any),
      whole("azimuth-bins", "bins of stratified cameras around the data set's z axis", azimuth_bins,
            1, 1000)
          .only_if(stratified, bins),
      whole("elevation-bins", "bins of stratified cameras from below to above", elevation_bins, 1,
            1000)
          .only_if(stratified, bins),
      choice("score-weight", "weight of a splat in a pixel", weight, kScoreWeightNames)
          .only_if(used, any),
      choice("score-loss", "loss in the metric maps", loss, kScoreLossNames).only_if(used, any),
      choice("score-unit", "unit of --tau-plus and --tau-minus", unit, kScoreUnitNames)
          .only_if(used, any),
      choice("score-normalization", "scores per covered pixel, or their sums", normalization,
             kScoreNormalizationNames)
          .only_if(used, any),
      real("tau-plus", "pixels with a larger loss are badly reconstructed", tau_plus, 0, kUnlimited)
          .only_if(uses_plus, "--densify multiview"),
      real("tau-minus", "pixels with a smaller loss are well reconstructed", tau_minus, 0,
           kUnlimited)
          .only_if(uses_minus, pruning),
      real("quantile-plus", "splats above this quantile of S+ may be cloned or split",
           quantile_plus, 0, 1)
          .only_if(uses_plus, "--densify multiview"),
      real("quantile-minus", "transparent splats above this quantile of S- are removed",
           quantile_minus, 0, 1)
          .only_if(uses_minus, pruning)};
}

SplatScores score_splats(const std::vector<View>& views, const std::vector<std::uint32_t>& sampled,
                         const PlanarFloats& parameters, const RenderOptions& render,
                         const ScoreOptions& options, double lambda_dssim, Rasterizer& rasterizer,
                         const Threads& threads) {
  const std::size_t count = parameters.size();
  SplatScores scores;
  for (auto* sums : {&scores.plus, &scores.minus, &scores.contribution, &scores.pixels})
    sums->resize(count);
  PlanarImage target;
  RmsLoss rms_loss;
  for (const std::uint32_t index : sampled) {
    const View& view = views[index];
    rasterizer.forward(parameters, view.camera, render);
    to_planar(view.rgb, threads, target);
    shift_background(view.alpha, glm::vec3(render.background) - view.background, target);
    fill_unused(view.used, rasterizer.color(), target);
    const PlanarImage loss = loss_map(rasterizer.color(), target,
                                      options.loss == ScoreLoss::l1 ? 0 : lambda_dssim, threads);
    rms_loss.add(loss, view.used);
    const PlanarFloats& sums =
        rasterizer.score(metric_maps(loss, options, view.used), options.weight);
    let_go(view);
    add(sums.row(score::first), scores.plus);
    add(sums.row(score::second), scores.minus);
    add(sums.row(score::contribution), scores.contribution);
    add(sums.row(score::pixels), scores.pixels);
  }
  scores.loss = rms_loss.value();
  if (options.normalization == ScoreNormalization::pixel)
    for (std::size_t i = 0; i < count; ++i) {
      scores.plus[i] /= std::max(scores.pixels[i], 1.0f);
      scores.minus[i] /= std::max(scores.pixels[i], 1.0f);
    }
  return scores;
}

float score_quantile(const std::vector<float>& values, const SplatScores& scores, double quantile,
                     ScoreNormalization normalization) {
  std::vector<float> counted;
  counted.reserve(values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    if (normalization == ScoreNormalization::sum || scores.pixels[i] > 0)
      counted.push_back(values[i]);
  if (counted.empty()) return -1;
  const auto at = counted.begin() +
                  static_cast<std::ptrdiff_t>(quantile * static_cast<double>(counted.size() - 1));
  std::nth_element(counted.begin(), at, counted.end());
  return *at;
}

}  // namespace fluxgs
