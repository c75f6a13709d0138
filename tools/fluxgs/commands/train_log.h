// Log of a training: means over equal stretches, the PSNR of the test views now and then, and the
// reports of phases. For the report and its plots.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "trainer/train/trainer.h"

namespace fluxgs::cli {

class TrainLog {
 public:
  explicit TrainLog(int iterations);  ///< of the whole training

  /// Takes a step in, and tells the user of what happened in it. Stretches end at the same steps
  /// wherever a training was interrupted; of one cut in two, the curves have the second part.
  void add(int iteration, const IterationReport& report, std::size_t splats);

  /// Twenty times in all, halfway between the even marks, at many of which opacities are reset.
  bool psnr_is_due(int iteration) const { return iteration % (10 * stretch_) == 5 * stretch_; }
  /// Measures the test views, if there are any; the time that takes is not part of the training's.
  void measure_psnr(int iteration, const Trainer& trainer, const std::vector<View>& views);
  double measuring_seconds() const { return measuring_; }
  double measuring_cpu_seconds() const { return measuring_cpu_; }

  nlohmann::json to_json() const;

 private:
  void add_phase(const PhaseReport& report);

  int stretch_, count_ = 0;
  double loss_ = 0, l1_ = 0, start_, measuring_ = 0, measuring_cpu_ = 0;
  std::vector<int> iteration_;
  std::vector<double> losses_, l1s_, rates_;
  std::vector<std::size_t> splats_;
  std::vector<std::pair<int, double>> psnr_;
  nlohmann::json phases_ = nlohmann::json::array();
};

/// Time and curves of a training so far, over all parts that interruptions cut it into.
struct TrainHistory {
  double seconds = 0, cpu_seconds = 0;
  std::uint64_t rejected_gradients = 0;      ///< that were not finite
  std::map<std::string, double> stages;      ///< seconds by name
  std::map<std::string, double> stages_cpu;  ///< seconds of processor time by name
  nlohmann::json curves;                     ///< TrainLog::to_json(); null: none yet
};

/// The history as text, for a checkpoint.
std::string text_of(const TrainHistory& history);

/// The other way round. Nothing of text that is not such, as in checkpoints of before there was
/// any.
TrainHistory history_of(const std::string& text);

/// One history of two parts of a training. Of what is said once, the last word counts.
TrainHistory joined(const TrainHistory& before, const TrainHistory& after);

}  // namespace fluxgs::cli
