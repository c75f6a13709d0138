// Chooses how many pixels and splats a frame has, so that it holds the display's rate and keeps the
// device cool.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

namespace fluxgs::viewer {

/// Amount of pixels and splats of a frame.
struct Detail {
  double scale = 1;       ///< of the image that is blended
  double min_weight = 0;  ///< of the splats, see render::ApproximationSettings
  bool operator==(const Detail&) const = default;
};

/// Steps that are tried: each scale has some 0.7 times the pixels of the one before. Dense scenes
/// have many splats that weigh little: without those below 1 a frame takes half of its time, at
/// 30 dB or more (docs/renderer.md). Other scenes have few of them, and lose nothing.
inline constexpr std::array<Detail, 6> kDetails{
    {{1, 0}, {0.85, 0}, {0.7, 0.5}, {0.6, 0.5}, {0.5, 1}, {0.4, 2}}};

/// Multiples of the time that a frame may take: above the first is too long, below the second fits.
inline constexpr double kTooLong = 1.2, kFits = 1.1;
/// Seconds; beyond, something else was going on than a frame.
inline constexpr double kLongestFrame = 0.5;

/// The temperature of the device, as Android reports it.
struct Heat {
  /// PowerManager.THERMAL_STATUS_…: 0 none, 1 light, 2 moderate, 3 severe, 4 critical, 5 emergency,
  /// 6 shutdown.
  int status = 0;
  /// PowerManager.getThermalHeadroom(): 1 is where severe throttling begins; NaN: not known.
  double headroom = 0;
};

/// The largest scale that is wise: below 1 before the system begins to throttle.
double coolest_scale(const Heat& heat);

/// One step down when frames take longer than the display's, which is seen soon; one step up when
/// they have fitted for long enough, and again down, and a longer wait, when that was too much.
/// What does not make frames shorter is taken back: where they wait for the sort or for the
/// display's own rate, less detail is only a worse image.
class DetailControl {
 public:
  /// `frame_seconds`: of the display; what is drawn should take no longer.
  explicit DetailControl(double frame_seconds = 1.0 / 60) : frame_seconds_(frame_seconds) {}

  void set_frame_seconds(double seconds);

  /// Tells how long a frame took that was drawn while others were too, from the one before. Returns
  /// the detail of the next.
  Detail frame(double seconds);

  /// The image stood still: what follows has nothing to do with the time between.
  void pause() { counted_ = 0; }

  void set_max(double scale) { most_ = scale; }  ///< coolest_scale(), or the user's

  Detail detail() const { return detail_at(step_); }

 private:
  struct Trial {
    std::size_t step = 0;  // it began at
    double mean = 0;       // of the frames there
  };
  Detail detail_at(std::size_t step) const;
  void judge_long();
  void change_to(std::size_t step);
  std::size_t next_down() const;
  void step_up();

  double frame_seconds_;
  double most_ = 1;
  std::size_t step_ = 0;        // into kDetails
  double mean_ = 0;             // of the frames' times, smoothed
  int counted_ = 0;             // frames since the last change or pause
  double fitting_ = 0;          // seconds for which frames have fitted
  double patience_ = 2;         // seconds to wait before a step up
  bool trying_ = false;         // the last change was a step up
  std::optional<Trial> trial_;  // of steps down whose gain is not known yet
  double resigned_ = 0;         // seconds yet without a step down, as the last ones gained nothing
  double resigned_mean_ = 0;    // of the frames before those
  double resignation_ = 0;      // how long the last such time was
};

}  // namespace fluxgs::viewer
