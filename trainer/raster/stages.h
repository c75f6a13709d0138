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
  count
};

inline constexpr std::array<std::string_view, 10> kStageNames = {
    "networks", "project",  "sort", "forward", "ssim",
    "backward", "gradient", "adam", "score",   "densify"};

/// Wall-clock seconds per stage, added up.
struct StageTimes {
  std::array<double, static_cast<std::size_t>(Stage::count)> seconds{};
  double& operator[](Stage s) { return seconds[static_cast<std::size_t>(s)]; }
  double operator[](Stage s) const { return seconds[static_cast<std::size_t>(s)]; }
};

/// Adds its own lifetime to a stage.
class StageTimer {
 public:
  StageTimer(StageTimes& times, Stage stage) : times_(times), stage_(stage) {}
  ~StageTimer() { times_[stage_] += std::chrono::duration<double>(Clock::now() - start_).count(); }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  StageTimes& times_;
  Stage stage_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace fluxgs
