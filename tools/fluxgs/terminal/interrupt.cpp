#include "tools/fluxgs/terminal/interrupt.h"

#include <atomic>
#include <csignal>

namespace fluxgs::cli {
namespace {

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};
std::atomic<int> interrupts = 0;

void count_only(int) { ++interrupts; }
void count_once(int signal) {
  ++interrupts;
  std::signal(signal, SIG_DFL);
}

}  // namespace

InterruptCounter::InterruptCounter(SecondInterrupt second) {
  interrupts = 0;
  const auto handle = second == SecondInterrupt::counts ? count_only : count_once;
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    before_[i] = std::signal(kSignals[i], handle);
    if (before_[i] == SIG_IGN) std::signal(kSignals[i], SIG_IGN);
  }
}

InterruptCounter::~InterruptCounter() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) std::signal(kSignals[i], before_[i]);
}

int InterruptCounter::count() const { return interrupts; }

}  // namespace fluxgs::cli
