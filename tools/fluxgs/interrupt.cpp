#include "tools/fluxgs/interrupt.h"

#include <atomic>
#include <csignal>

namespace fluxgs::cli {
namespace {

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};
std::atomic<int> interrupts = 0;

void handle(int) { ++interrupts; }

}  // namespace

InterruptCounter::InterruptCounter() {
  interrupts = 0;
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
