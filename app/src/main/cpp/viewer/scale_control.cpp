#include "viewer/scale_control.h"

#include <algorithm>
#include <cmath>

namespace fluxgs::viewer {
namespace {

constexpr double kTooLong = 1.2, kFits = 1.1;  // of the display's frame
constexpr double kSmoothing = 0.15;
constexpr int kFramesToJudge = 12;                   // after a change
constexpr double kLongestPatience = 60, kProof = 2;  // seconds
constexpr double kLongestFrame = 0.5;                // beyond, something else was going on

}  // namespace

double coolest_scale(const Heat& heat) {
  constexpr double kWarm = 0.85, kHot = 0.95;  // headroom
  const double headroom = std::isnan(heat.headroom) ? 0 : heat.headroom;
  if (heat.status >= 3) return 0.5;
  if (heat.status == 2 || headroom >= kHot) return 0.7;
  if (heat.status == 1 || headroom >= kWarm) return 0.85;
  return 1;
}

void ScaleControl::set_frame_seconds(double seconds) {
  if (seconds > 0 && std::isfinite(seconds)) frame_seconds_ = seconds;
}

double ScaleControl::scale() const { return std::min(kScales.at(step_), most_); }

double ScaleControl::frame(double seconds) {
  if (!(seconds > 0) || seconds > kLongestFrame) return scale();
  mean_ = counted_ == 0 ? seconds : std::lerp(mean_, seconds, kSmoothing);
  if (++counted_ < kFramesToJudge) return scale();
  if (mean_ > kTooLong * frame_seconds_) {
    step_down();
  } else if (mean_ <= kFits * frame_seconds_) {
    fitting_ += seconds;
    if (fitting_ >= kProof) trying_ = false;
    if (fitting_ >= patience_) step_up();
  } else {
    fitting_ = 0;
  }
  return scale();
}

void ScaleControl::step_down() {
  if (trying_) patience_ = std::min(2 * patience_, kLongestPatience);
  // Steps above what is allowed change nothing
  while (step_ + 1 < kScales.size() && kScales.at(step_ + 1) >= most_) ++step_;
  if (step_ + 1 < kScales.size()) ++step_;
  trying_ = false;
  counted_ = 0;
  fitting_ = 0;
}

void ScaleControl::step_up() {
  fitting_ = 0;
  if (step_ == 0 || kScales.at(step_) >= most_) return;
  --step_;
  trying_ = true;
  counted_ = 0;
}

}  // namespace fluxgs::viewer
