// Scores of splats by the errors that they take part in, over several views (paper, "Multi-view
// Alpha-Weighted Error Accumulation").
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "trainer/core/parallel.h"
#include "trainer/core/parameters.h"
#include "trainer/data/dataset.h"
#include "trainer/model/options.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {

/// The loss that the metric maps are made of.
enum class ScoreLoss { l1, l1_dssim };
inline constexpr std::array<std::string_view, 2> kScoreLossNames = {"l1", "l1-dssim"};

/// Units of the thresholds τ± of the metric maps.
enum class ScoreUnit {
  percentile,  ///< the loss's 99.5th percentile in the image, but at least a floor
  raw,         ///< the loss itself
};
inline constexpr std::array<std::string_view, 2> kScoreUnitNames = {"percentile", "raw"};

/// Divisor of a splat's sums over pixels.
enum class ScoreNormalization {
  pixel,  ///< the pixels it covers; splats that no view saw do not count in quantiles
  sum,    ///< none, and every splat counts (the paper to the letter)
};
inline constexpr std::array<std::string_view, 2> kScoreNormalizationNames = {"pixel", "sum"};

inline constexpr std::array<std::string_view, 2> kScoreWeightNames = {"alpha", "alpha-t"};

/// Choice of the views that scores are taken from.
enum class CameraSampling { stratified, random };
inline constexpr std::array<std::string_view, 2> kCameraSamplingNames = {"stratified", "random"};

/// Paper, "Multi-view Alpha-based Densification and Pruning".
struct ScoreOptions {
  static constexpr const char* kTitle = "Multi-view scores";
  int views = 6;
  CameraSampling sampling = CameraSampling::stratified;
  int azimuth_bins = 12, elevation_bins = 6;  ///< M_θ, M_φ of stratified sampling
  ScoreWeight weight = ScoreWeight::alpha;
  ScoreLoss loss = ScoreLoss::l1_dssim;
  ScoreUnit unit = ScoreUnit::percentile;
  ScoreNormalization normalization = ScoreNormalization::pixel;
  double tau_plus = 0.1, tau_minus = 0.01;           ///< τ⁺, τ⁻, in `unit`
  double quantile_plus = 0.6, quantile_minus = 0.1;  ///< Q⁺, Q⁻, 0…1
  /// True if a phase of the schedule looks at S⁺, at S⁻; set when the schedule is made.
  bool uses_plus = false, uses_minus = false;

  OptionFields fields(const TrainOptions& all);
};

/// One entry for each splat.
struct SplatScores {
  std::vector<float> plus, minus;   ///< S⁺, S⁻: sums over all views, or per pixel
  std::vector<float> contribution;  ///< Σ α·T over all pixels of all views
  std::vector<float> pixels;        ///< pixels it contributes to, over all views; 0: not seen
  bool sampled = false;             ///< there are views beside these, which may see other splats
  double loss = 0;                  ///< root mean square over the pixels that count, of all views
};

/// Renders `views[sampled[0]]`, … and adds up; ignored pixels add nothing. `lambda_dssim`: weight
/// of 1 − SSIM in the loss.
SplatScores score_splats(const std::vector<View>& views, const std::vector<std::uint32_t>& sampled,
                         const PlanarFloats& parameters, const RenderOptions& render,
                         const ScoreOptions& options, double lambda_dssim, Rasterizer& rasterizer,
                         const Threads& threads);

/// The value that a fraction `quantile` of the splats have at most. ScoreNormalization::pixel: of
/// those that some view saw. −1 if there are none.
float score_quantile(const std::vector<float>& values, const SplatScores& scores, double quantile,
                     ScoreNormalization normalization);

}  // namespace fluxgs
