// A training at work, as fluxgs train runs it: iterations, checkpoints, then the results.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "fluxgs/io/write_options.h"
#include "tools/fluxgs/commands/preview.h"
#include "tools/fluxgs/commands/train_log.h"
#include "tools/fluxgs/commands/train_run.h"
#include "tools/fluxgs/terminal/interrupt.h"
#include "tools/fluxgs/terminal/progress.h"
#include "trainer/core/clock.h"
#include "trainer/train/run_estimate.h"
#include "trainer/train/store_scene.h"

namespace fluxgs::cli {

/// Everything but the constructor is called once, in this order.
class TrainWork {
 public:
  /// `settings` and `threads` must outlive it.
  TrainWork(const TrainSettings& settings, Run run, const Threads& threads);

  /// Iterates to the end. An interruption saves a checkpoint and is an error that says how to go
  /// on.
  Expected<void> to_end();

  /// The scene and its error, the report, then the floats: small files first, so that they are
  /// there if the disk is full. Nothing of the training is lost where one fails.
  Expected<void> write_results();

  /// Says what was made, and what can be done with it.
  void say_what_next();

 private:
  Expected<void> step(Progress& progress);
  Expected<void> interrupted(const Expected<void>& saved, const std::string& where) const;
  Expected<void> save();
  void save_if_due(bool due);
  TrainHistory history() const;
  void make_report();
  void say_expected();
  Expected<void> write_scene_and_score();
  WriteOptions from_start() const;
  Expected<std::optional<SplatCloud>> write_trained(const std::string& path) const;
  Expected<std::optional<SplatCloud>> write_out();
  Expected<StoredScene> store();
  Expected<void> score(const std::optional<SplatCloud>& stored);
  Expected<void> write_float_output();
  Expected<void> keep_training(const Error& error);
  std::optional<std::string> save_elsewhere();
  void warn_of_missed_target() const;
  void tell(const std::string& line) const;
  void set_interrupt_lines(const std::string& first);

  const TrainSettings& settings_;
  Run run_;
  const Threads& threads_;
  Interrupts interrupts_{
      "fluxgs: stopping after this iteration with a checkpoint; again to quit at once (no "
      "checkpoint "
      "has been saved yet)",
      "fluxgs: quit without a checkpoint"};
  int first_;  ///< the iterations that were done before
  Profiler profiler_;
  Trainer trainer_;
  Preview preview_;
  TrainLog log_;
  const double start_ = wall_seconds(), cpu_start_ = cpu_seconds();
  RunEstimate estimate_;
  /// Time and memory of the whole run: seconds, bytes.
  struct Needs {
    double seconds = 0, memory = 0;
  };
  std::optional<Needs> expected_, said_;  ///< as said first, and last
  double estimated_at_ = 0;               ///< seconds since the start
  double smooth_loss_ = 0;
  std::optional<TrainHistory> whole_;  ///< once all iterations are done
  double saved_at_ = start_;           ///< time of the last checkpoint
  std::optional<int> saved_iteration_;
  double saving_seconds_ = 0;
  int saves_ = 0;
  nlohmann::json report_;
};

}  // namespace fluxgs::cli
