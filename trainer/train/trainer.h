// The training loop, one iteration at a time.
#pragma once

#include <memory>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/core/profiler.h"
#include "trainer/data/dataset.h"
#include "trainer/data/initial_points.h"
#include "trainer/loss/photometric.h"
#include "trainer/model/phase.h"
#include "trainer/raster/rasterizer.h"
#include "trainer/train/schedule.h"

namespace fluxgs {

/// The most training views, and test views, whose mean PSNR is measured before and after an event.
inline constexpr std::size_t kEventViews = 8;

/// Result of one iteration.
struct IterationReport {
  double loss = 0;  ///< without penalties, of the image at its size in this iteration
  PhotometricSums sums;
  RasterCounts raster;
  std::vector<PhaseReport> phases;  ///< of the events that took place
};

/// The factor of all learning rates at an iteration (1, 2, …): 1 before the cooldown.
double cooldown_factor(const CommonOptions& options, int iteration);

/// The scene's size: 1.1 × the largest distance of a camera from their mean (3DGS).
double scene_extent(const std::vector<View>& views);

/// The state before the first iteration, from a data set's initial points.
TrainState initial_state(const Dataset& data, const PointCloud& points, const TrainOptions& options,
                         const Threads& threads);

/// Runs iterations on a state. `data`, `threads` and `profiler` must outlive it. The same data,
/// options, state and instruction set give the same bytes for any number of threads.
class Trainer final : public Training {
 public:
  Trainer(const Dataset& dataset, const TrainOptions& asked, TrainState initial,
          const Threads& pool, Profiler& times);

  bool done() const { return state.iteration >= options.iterations; }
  /// The phase with an event at this iteration, which then takes longer than others; null where
  /// there is none.
  const Phase* event_at(int iteration) const;
  IterationReport step();

  const Schedule& schedule() const { return schedule_; }
  /// The state with what phases keep: the content of a checkpoint.
  TrainState saved_state() const;
  SplatCloud cloud() const override;
  double mean_psnr(const std::vector<View>& views, std::size_t most = kMeasuredViews,
                   const ProgressReport& shown = {}) const override;
  /// PSNR between renders of the scene and of its compact file (compress/compression.h).
  double compressed_psnr() const;
  /// Gradients that were not finite and were therefore skipped.
  std::uint64_t rejected_gradients() const;

  RenderOptions render_options() const override;
  double position_lr() const override;
  std::uint64_t max_splats() const override;
  void complete_colors() override;

 private:
  const View& next_view();
  void optimize();
  std::vector<std::uint8_t> visible_of_degree(int degree) const;
  void run_after_step(Phase& phase, IterationReport& report);
  void run_event(Phase& phase, IterationReport& report);
  void add_event(const Phase& phase, PhaseReport event, std::size_t splats_before,
                 IterationReport& report) const;

  // Training refers to these
  struct Owned {
    Schedule schedule;
    TrainState state;
    std::unique_ptr<Rasterizer> rasterizer;
  };
  Trainer(const Dataset& dataset, std::unique_ptr<Owned> owned, const Threads& pool,
          Profiler& times);

  std::unique_ptr<Owned> owned_;
  const Schedule& schedule_;
  PhotometricLoss loss_;
  PlanarImage target_;
};

}  // namespace fluxgs
