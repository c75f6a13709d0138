// Phases: the optional parts of a training. A phase is one file with its options, what it does at
// which point of an iteration, and what it cost and gained. train/schedule.cpp lists them all in
// the order in which they run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "fluxgs/camera.h"
#include "fluxgs/error.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/core/parallel.h"
#include "trainer/core/progress.h"
#include "trainer/model/options.h"
#include "trainer/model/train_state.h"

namespace fluxgs {

struct Dataset;
struct View;
class PlanarImage;
class Profiler;
class Rasterizer;

/// A quantity before and after.
template <class T>
struct Change {
  T before = {}, after = {};
};

/// Cost and gain of an event of a phase. The trainer measures name, iteration, PSNR and splats;
/// the phase adds the rest.
struct PhaseReport {
  std::string name;
  int iteration = 0;
  Change<double> train_psnr;                ///< dB, means over the views
  std::optional<Change<double>> test_psnr;  ///< where there are test views
  Change<std::size_t> splats;
  std::optional<Change<std::size_t>> bytes;           ///< of compact files
  nlohmann::json details = nlohmann::json::object();  ///< of this phase alone
  std::string summary = {};                           ///< of the details, for the log
};

/// The iterations at which a phase is at work: the multiples of `interval` from `from` to `until`.
struct Period {
  int from = 0, until = 0;
  int interval = 1;   ///< 0: once, at `from`
  int first() const;  ///< the first iteration at which it is due, if any is
  /// True if anything takes place within so many iterations.
  bool takes_place(int iterations) const;
  bool due(int iteration) const;
};

/// The views whose mean PSNR tells that of many.
inline constexpr std::size_t kMeasuredViews = 100;

/// Work that takes time, in units that scale with images and splats.
struct PhaseWork {
  double renders = 0;  ///< of full-size training views that take about as long
  double files = 0;    ///< compact files of the scene, written and read
  double growth = 0;   ///< change of the logarithm of the number of splats, as one expects

  /// One number for a progress bar.
  double share() const { return renders + 3 * files; }
};

/// The running training, as phases see it.
class Training {
 public:
  virtual ~Training() = default;

  const Dataset& data;
  const TrainOptions& options;  ///< resolved
  const Threads& threads;
  TrainState& state;
  Rasterizer& rasterizer;
  Profiler& profiler;
  double extent;  ///< the scene's size: 1.1 × the largest distance of a camera from their mean

  /// The training views at the resolution of this iteration.
  const std::vector<View>* views = nullptr;
  const View* view = nullptr;  ///< of this iteration
  RenderOptions render = {};   ///< of this iteration
  /// ∂L/∂transmittance of what a phase adds to this iteration's loss (Rasterizer::backward()).
  const PlanarImage* transmittance_gradient = nullptr;
  /// Rows of the parameters that the trainer's own optimiser moves end here, if not with the SH
  /// degree in use.
  std::optional<int> optimized_rows;
  /// Opacity logits of all splats where a phase has changed those of the parameters for this
  /// iteration; otherwise empty.
  std::vector<float> true_opacities;

  /// Long work of phases and of the trainer is shown here.
  ProgressReport progress = {};

  /// Exchanges true and changed opacities, if there are any.
  void exchange_opacities();

  /// Options of a render at the current iteration.
  virtual RenderOptions render_options() const = 0;
  virtual double position_lr() const = 0;  ///< at the current iteration, scene units
  /// Options with the limit that memory sets to the number of splats.
  virtual std::uint64_t max_splats() const = 0;  ///< 0: no limit
  /// Lets the parameters hold the colours of all splats, also those that were not visible lately.
  virtual void complete_colors() = 0;
  virtual SplatCloud cloud() const = 0;  ///< the scene as it is shown
  /// dB, the mean over `most` of the views, evenly spread, each kMaxPsnr at most; 0 without any.
  virtual double mean_psnr(const std::vector<View>& views, std::size_t most = kMeasuredViews,
                           const ProgressReport& shown = {}) const = 0;

 protected:
  Training(const Dataset& data_, const TrainOptions& options_, const Threads& threads_,
           TrainState& state_, Rasterizer& rasterizer_, Profiler& profiler_, double extent_)
      : data(data_),
        options(options_),
        threads(threads_),
        state(state_),
        rasterizer(rasterizer_),
        profiler(profiler_),
        extent(extent_) {}
};

class Phase {
 public:
  virtual ~Phase() = default;

  virtual const char* name() const = 0;
  virtual Period period() const = 0;
  /// The effect of the phase, for the schedule: a sentence without a full stop.
  virtual std::string effect() const = 0;
  /// Reason why the phase will not do what was asked for; empty: it will.
  virtual std::string warning() const { return {}; }

  // The points of an iteration. state.iteration counts the iterations done; it grows after begin().

  /// Chooses what is rendered.
  virtual void begin(Training&) {}
  /// Changes the options of renders at the current iteration.
  virtual void configure(RenderOptions&, const TrainState&) const {}
  /// Changes the parameters for this iteration.
  virtual void before_render(Training&) {}
  /// Uses or changes gradients; parameters have not moved yet.
  virtual void before_backward(Training&) {}
  virtual void after_backward(Training&) {}
  /// True if after_step() of this iteration is an event, whose effect is measured.
  virtual bool reports(int /*iteration*/) const { return false; }
  /// Work of the phase at this iteration beside its work at all of them. `views`: of the
  /// training.
  virtual PhaseWork work(int /*iteration*/, std::size_t /*views*/) const { return {}; }
  /// Pixels of the training images at this iteration, as a share of all.
  virtual double pixel_share(int /*iteration*/) const { return 1; }
  /// SH degree in use at this iteration, out of `degree`, which the other phases leave.
  virtual int sh_degree(int /*iteration*/, int degree) const { return degree; }
  /// Changes the scene, after the optimiser has moved the parameters. Returns a report of what
  /// happened, if anything did that a user wants to know.
  virtual std::optional<PhaseReport> after_step(Training&) { return {}; }

  /// True if the phase makes colours that the parameters do not hold.
  virtual bool has_colors() const { return false; }
  /// Writes such colours of all splats into rows sh_dc and sh_rest of the parameters, or a copy.
  virtual void bake_colors(const TrainState&, PlanarFloats& /*parameters*/) const {}
  virtual std::uint64_t rejected_gradients() const { return 0; }  ///< that were not finite

  /// Values that a checkpoint holds of the phase beside the splats. load() refuses what save()
  /// cannot have made in a training with that state; it is given nothing where nothing was saved.
  virtual std::vector<double> save() const { return {}; }
  virtual Expected<void> load(const std::vector<double>&, const TrainState&) { return {}; }
};

}  // namespace fluxgs
