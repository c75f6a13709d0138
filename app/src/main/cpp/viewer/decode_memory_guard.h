// Counts the threads that hold the memory of a scene while they decode it.
#pragma once

#include <atomic>

namespace fluxgs::viewer {

/// One for each thread that decodes a scene, or tests with one, and has it until it has finished,
/// wanted or not. Memory that is free counts for another scene once none is left.
class DecodeMemoryGuard {
 public:
  DecodeMemoryGuard() { ++count_; }
  DecodeMemoryGuard(const DecodeMemoryGuard&) = delete;
  DecodeMemoryGuard& operator=(const DecodeMemoryGuard&) = delete;
  ~DecodeMemoryGuard() {
    --count_;
    count_.notify_all();
  }

  /// Returns once there is none. From any thread that has none itself.
  static void wait_for_none() {
    for (int now = count_; now != 0; now = count_) count_.wait(now);
  }

 private:
  inline static std::atomic<int> count_ = 0;
};

}  // namespace fluxgs::viewer
