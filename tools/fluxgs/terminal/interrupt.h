// Ctrl-C, kill and a closed terminal, noticed by work that wants to end in its own way.
#pragma once

#include <array>

namespace fluxgs::cli {

/// Effect of a second signal.
enum class SecondInterrupt { counts, ends_the_program };

/// While it lives these signals are counted and do nothing else. Those that are ignored (nohup)
/// stay so. One at a time in a process.
class InterruptCounter {
 public:
  explicit InterruptCounter(SecondInterrupt second = SecondInterrupt::counts);
  ~InterruptCounter();
  InterruptCounter(const InterruptCounter&) = delete;
  InterruptCounter& operator=(const InterruptCounter&) = delete;

  int count() const;

 private:
  std::array<void (*)(int), 3> before_{};
};

}  // namespace fluxgs::cli
