// The rate that frames are drawn at, and the detail that holds it: 60 a second, or those of a
// faster display where nearly all pixels are there at that rate.
#pragma once

#include "viewer/detail_control.h"

namespace fluxgs::viewer {

/// A faster display is tried after a while in which frames have fitted, and given up for a longer
/// while where they need fewer pixels than kLeastScale, or come late all the same. Heat takes the
/// faster rate first, pixels second.
class FrameGoal {
 public:
  static constexpr double kLeastScale = 0.85;  ///< at the faster rate

  /// Seconds of the shortest frame that the display has.
  void set_display(double seconds);
  void set_heat(const Heat& heat);
  /// The largest scale that is wanted while something moves.
  void set_most(double scale);

  /// Tells how long a frame took that was drawn while others were too, from the one before.
  void frame(double seconds);
  /// See DetailControl::pause().
  void pause() { control_.pause(); }

  double seconds() const;  ///< that a frame may take
  Detail detail() const { return control_.detail(); }
  /// The largest scale that heat allows: that of a view at rest.
  double coolest() const { return coolest_; }

 private:
  bool is_faster() const;
  void limit_scale();
  void try_faster();
  void give_up();
  void judge_faster(double seconds);

  DetailControl control_, before_;  ///< before the faster rate
  double display_ = 1.0 / 60;
  double coolest_ = 1, most_ = 1;
  bool cool_ = true;     ///< enough for the faster rate
  bool fast_ = false;    ///< the faster rate is the goal
  double fitting_ = 0;   ///< seconds for which frames have fitted the slower rate
  double patience_ = 2;  ///< seconds of that before the faster rate is tried
  double late_ = 0;  ///< seconds of frames that came late at the faster rate, less those in time
  double held_ = 0;  ///< seconds at the faster rate
};

}  // namespace fluxgs::viewer
