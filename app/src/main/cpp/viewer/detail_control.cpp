#include "viewer/detail_control.h"

#include <algorithm>
#include <cmath>

namespace fluxgs::viewer {
namespace {

constexpr double kTimeSmoothing = 0.15;
constexpr int kFramesToJudge = 12;                   // after a change
constexpr double kLongestPatience = 60, kProof = 2;  // seconds
constexpr int kFramesOfChange = 3;                   // in which new images are made
constexpr double kChange = 1.3;                      // of the frames' time: another view
constexpr double kGain = 0.95;  // of a frame's time, at most, after a step that was worth it
constexpr double kShortestResignation = 8, kLongestResignation = 60;  // seconds

}  // namespace

double coolest_scale(const Heat& heat) {
  constexpr double kWarm = 0.85, kHot = 0.95;  // headroom
  const double headroom = std::isnan(heat.headroom) ? 0 : heat.headroom;
  if (heat.status >= 3) return 0.5;
  if (heat.status == 2 || headroom >= kHot) return 0.7;
  if (heat.status == 1 || headroom >= kWarm) return 0.85;
  return 1;
}

void DetailControl::set_frame_seconds(double seconds) {
  if (seconds > 0 && std::isfinite(seconds)) frame_seconds_ = seconds;
}

Detail DetailControl::detail_at(std::size_t step) const {
  const Detail& detail = kDetails.at(step);
  return {std::min(detail.scale, most_), detail.min_weight};
}

Detail DetailControl::frame(double seconds) {
  if (!(seconds > 0) || seconds > kLongestFrame) return detail();
  resigned_ = std::max(resigned_ - seconds, 0.0);
  mean_ = counted_ <= 0 ? seconds : std::lerp(mean_, seconds, kTimeSmoothing);
  if (++counted_ < kFramesToJudge) return detail();
  if (mean_ > kTooLong * frame_seconds_) {
    fitting_ = 0;
    judge_long();
    return detail();
  }
  trial_.reset();
  if (mean_ > kFits * frame_seconds_) {
    fitting_ = 0;
    return detail();
  }
  fitting_ += seconds;
  if (fitting_ >= kProof) trying_ = false;
  if (fitting_ >= patience_) step_up();
  return detail();
}

void DetailControl::judge_long() {
  const bool at_the_end = next_down() == step_;
  if (trying_) {  // a step up that was too much
    patience_ = std::min(2 * patience_, kLongestPatience);
    return change_to(next_down());
  }
  const bool gained =
      trial_ && mean_ <= trial_->mean * std::pow(kGain, static_cast<double>(step_ - trial_->step));
  if (gained) resignation_ = 0;
  if (gained || !trial_) {
    const bool resigned = resigned_ > 0 && mean_ < kChange * resigned_mean_;
    if (resigned || at_the_end) return;
    trial_ = {step_, mean_};
    return change_to(next_down());
  }
  // Where the display waits for whole frames, steps may show nothing until one is enough
  if (!at_the_end) return change_to(next_down());
  resignation_ = std::clamp(2 * resignation_, kShortestResignation, kLongestResignation);
  resigned_ = resignation_;
  resigned_mean_ = trial_->mean;
  change_to(trial_->step);
  trial_.reset();
}

/// The next step that can be seen, if there is one: a scale above what is allowed changes nothing.
std::size_t DetailControl::next_down() const {
  std::size_t step = step_ + 1;
  while (step < kDetails.size() && detail_at(step) == detail()) ++step;
  return step < kDetails.size() ? step : step_;
}

void DetailControl::change_to(std::size_t step) {
  step_ = step;
  trying_ = false;
  counted_ = -kFramesOfChange;
  fitting_ = 0;
}

void DetailControl::step_up() {
  fitting_ = 0;
  std::size_t step = step_;
  while (step > 0 && detail_at(step) == detail()) --step;
  if (detail_at(step) == detail()) return;
  change_to(step);
  trying_ = true;
}

}  // namespace fluxgs::viewer
