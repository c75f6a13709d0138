// The training loop, one step at a time.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "fluxgs/error.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/compress/sh_reduction.h"
#include "trainer/data/dataset.h"
#include "trainer/data/initial_points.h"
#include "trainer/data/pyramid.h"
#include "trainer/densify/density_control.h"
#include "trainer/densify/dropout.h"
#include "trainer/loss/photometric.h"
#include "trainer/model/options.h"
#include "trainer/model/train_state.h"
#include "trainer/paper/appearance_pass.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {

/// What the reduction of the SH coefficients did to the images.
struct SwitchReport {
  ReductionReport reduction;
  double train_psnr_before = 0, train_psnr_after = 0;  ///< dB, means over the views
  std::optional<std::array<double, 2>> test_psnr;  ///< before and after, if there are test views
  std::size_t bytes_before = 0, bytes_after = 0;   ///< of compact files with the usual steps
};

/// What splats that were removed late were worth.
struct LatePruneReport {
  std::size_t splats_before = 0, splats_after = 0;
  double train_psnr_before = 0, train_psnr_after = 0;
};

/// What rounding did to the images.
struct RoundingReport {
  std::size_t bytes = 0;  ///< of a compact file
  double train_psnr_before = 0, train_psnr_after = 0;
  std::optional<Error> error;  ///< why there is no rounding
};

/// What one step did.
struct StepReport {
  double loss = 0;  ///< without penalties, of the image at its size in this step
  PhotometricSums sums;
  RasterCounts raster;
  DensifyCounts densified;               ///< zero at most steps
  std::optional<SwitchReport> switched;  ///< at the step after which SH coefficients were reduced
  std::optional<LatePruneReport> pruned_late;
  std::optional<RoundingReport> rounded;  ///< at the step after which rounding began, or failed
};

/// The scene's size: 1.1 × the largest distance of a camera from their mean (3DGS).
double scene_extent(const std::vector<View>& views);

/// The state before the first step, from a data set's initial points.
TrainState initial_state(const Dataset& data, const PointCloud& points, const TrainOptions& options,
                         const Threads& threads);

/// Runs steps on a state. `data`, `threads` and `times` must outlive it. The same data, options,
/// state and instruction set give the same bytes for any number of threads.
class Trainer {
 public:
  Trainer(const Dataset& data, const TrainOptions& options, TrainState state,
          const Threads& threads, StageTimes& times);

  bool done() const { return state_.iteration >= options_.iterations; }
  StepReport step();

  const TrainState& state() const { return state_; }
  const TrainOptions& options() const { return options_; }
  SplatCloud cloud() const;
  /// dB, the mean over images, each 58.9 dB (their own rounding) at most; 0 without any.
  double mean_psnr(const std::vector<View>& views) const;
  /// dB between images of the scene and of a file that costs `store_loss` on the training views,
  /// `store_psnr` at most.
  double stored_psnr() const;
  /// Gradients that were not finite and were therefore skipped.
  std::uint64_t rejected_gradients() const {
    return rasterizer_->rejected_gradients() + networks_.rejected_gradients();
  }

 private:
  const View& next_view();
  int sh_degree_in_use() const;
  void shade(const Camera& camera, const RenderOptions& render);
  void optimize();
  void optimize_networks(const AdamConstants& constants);
  int latent_steps() const;
  std::vector<std::uint8_t> visible_of_degree(int degree) const;
  SwitchReport switch_appearance();
  std::optional<RoundingReport> round();
  RoundingReport begin_rounding();
  int coarse_level(int done) const;  ///< of the step after so many
  LearningRates rates() const;
  RenderOptions render_options() const;
  bool due(int from, int until, int interval) const;
  std::size_t compact_bytes() const;
  void control_density(StepReport& report);
  TrainOptions options_for_growth() const;
  DensifyCounts densify();
  LatePruneReport late_prune();
  SplatScores scores(const std::vector<std::uint32_t>& views);
  SplatScores contributions() const;

  const Dataset& data_;
  TrainOptions options_;
  TrainState state_;
  const Threads& threads_;
  StageTimes& times_;
  double extent_;
  ViewPyramid views_;
  std::unique_ptr<Rasterizer> rasterizer_;
  PhotometricLoss loss_;
  Dropout dropout_;
  PlanarImage target_;
  AppearancePass networks_;
  PlanarFloats latent_gradient_;
};

}  // namespace fluxgs
