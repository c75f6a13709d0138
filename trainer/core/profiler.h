// Where an iteration's time goes.
#pragma once

#include <array>
#include <chrono>
#include <string_view>

namespace fluxgs {

enum class Stage {
  networks,
  project,
  sort,
  forward,
  loss,
  backward,
  gradient,
  optimizer,
  score,
  densify,
  late_prune,
  appearance,  ///< the switch to fewer SH coefficients
  rounding,
  count
};

inline constexpr std::array<std::string_view, 13> kStageNames = {
    "networks", "project", "sort",    "forward",    "ssim",   "backward", "gradient",
    "adam",     "score",   "densify", "late prune", "switch", "rounding"};

class StageTimer;

/// Wall-clock seconds per stage, added up. No second is in two of them.
struct StageTimes {
  std::array<double, static_cast<std::size_t>(Stage::count)> seconds{};
  StageTimer* running = nullptr;
  double& operator[](Stage s) { return seconds[static_cast<std::size_t>(s)]; }
  double operator[](Stage s) const { return seconds[static_cast<std::size_t>(s)]; }
};

/// Adds its own lifetime to a stage, without that of the timers that are made and gone meanwhile.
/// Those of one StageTimes belong to one thread.
class StageTimer {
 public:
  StageTimer(StageTimes& times, Stage stage) : times_(times), outer_(times.running), stage_(stage) {
    if (outer_) outer_->stop();
    times_.running = this;
  }
  ~StageTimer() {
    stop();
    times_.running = outer_;
    if (outer_) outer_->start_ = Clock::now();
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  void stop() { times_[stage_] += std::chrono::duration<double>(Clock::now() - start_).count(); }

  StageTimes& times_;
  StageTimer* outer_;
  Stage stage_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace fluxgs
