#include "viewer/frame_goal.h"

#include <algorithm>
#include <cmath>

namespace fluxgs::viewer {
namespace {

constexpr double kUsual = 1.0 / 60;                   // seconds of a frame
constexpr double kFaster = 0.9;                       // of kUsual: less is another rate
constexpr double kTooLate = 0.7, kHeld = 5;           // seconds
constexpr double kPatience = 2, kMostPatience = 120;  // seconds

}  // namespace

bool FrameGoal::is_faster() const { return display_ < kFaster * kUsual; }

double FrameGoal::seconds() const { return fast_ ? display_ : std::max(display_, kUsual); }

void FrameGoal::set_display(double seconds) {
  if (!(seconds > 0) || !std::isfinite(seconds) || seconds == display_) return;
  display_ = seconds;
  fast_ = false;
  fitting_ = 0;
  patience_ = kPatience;
  control_.set_frame_seconds(this->seconds());
}

void FrameGoal::set_heat(const Heat& heat) {
  cool_ = coolest_scale(heat) == 1;
  // The first sign costs a faster display its rate, and no pixels
  const bool by_rate = is_faster() && heat.status <= 1 && coolest_scale(heat) >= kLeastScale;
  coolest_ = by_rate ? 1 : coolest_scale(heat);
  limit_scale();
  if (fast_ && !cool_) give_up();
}

void FrameGoal::set_most(double scale) {
  most_ = scale;
  limit_scale();
}

void FrameGoal::limit_scale() {
  control_.set_max(std::min(coolest_, most_));
  before_.set_max(std::min(coolest_, most_));
}

void FrameGoal::frame(double seconds) {
  if (!(seconds > 0) || seconds > kLongestFrame) return;
  control_.frame(seconds);
  if (!is_faster()) return;
  if (fast_) return judge_faster(seconds);
  const bool fits =
      seconds <= kFits * kUsual && control_.detail().scale >= std::min(coolest_, kLeastScale);
  fitting_ = fits ? fitting_ + seconds : 0;
  if (cool_ && fitting_ >= patience_) try_faster();
}

void FrameGoal::judge_faster(double seconds) {
  held_ += seconds;
  late_ = seconds > kTooLong * display_ ? late_ + seconds : std::max(late_ - 2 * seconds, 0.0);
  if (control_.detail().scale < kLeastScale || late_ > kTooLate) give_up();
}

void FrameGoal::try_faster() {
  before_ = control_;
  fast_ = true;
  late_ = held_ = fitting_ = 0;
  control_.set_frame_seconds(display_);
  control_.pause();
}

void FrameGoal::give_up() {
  fast_ = false;
  control_ = before_;
  control_.pause();
  fitting_ = 0;
  patience_ = held_ >= kHeld ? kPatience : std::min(2 * patience_, kMostPatience);
}

}  // namespace fluxgs::viewer
