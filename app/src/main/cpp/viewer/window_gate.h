// The right to draw in a window, which one thread gives and takes away, and another uses.
#pragma once

#include <cstdint>
#include <mutex>
#include <utility>

namespace fluxgs::viewer {

/// Thread-safe. A thread that owns windows must not wait for one that draws: that one may be
/// compiling, or uploading a scene, for seconds. It only waits for the end of a draw into a window.
class WindowGate {
 public:
  /// Owner: there is a window. Returns its number, for the drawing thread.
  std::uint64_t offer() {
    const std::lock_guard lock(mutex_);
    return ++offered_;
  }
  /// Owner: no window of those offered is drawn in from now on.
  void take_back() {
    const std::lock_guard lock(mutex_);
    taken_back_ = offered_;
  }

  /// Drawing thread: the window with this number is drawn in from now on.
  void use(std::uint64_t number) {
    const std::lock_guard lock(mutex_);
    used_ = number;
  }
  /// Drawing thread: draws, or returns `otherwise` where the window has been taken back.
  template <class Result, class Draw>
  Result draw_or(Result otherwise, Draw&& draw) {
    const std::lock_guard lock(mutex_);
    if (used_ <= taken_back_) return otherwise;
    return std::forward<Draw>(draw)();
  }

 private:
  std::mutex mutex_;
  // Numbers of windows; the first is that of a screen without others
  std::uint64_t offered_ = 1, used_ = 1, taken_back_ = 0;
};

}  // namespace fluxgs::viewer
