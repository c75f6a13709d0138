#include "tools/fluxgs/terminal/interrupt.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>

#include "tools/fluxgs/terminal/run_lock.h"

namespace fluxgs::cli {
namespace {

constexpr double kSamePress = 0.5;  // seconds

/// A line that a signal handler may read at any time: it sees the old or the new one, whole.
class SharedLine {
 public:
  void set(const std::string& text) {
    const int next = 1 - now_.load();
    auto& line = lines_[static_cast<std::size_t>(next)];
    const std::size_t length = std::min(text.size(), line.size() - 2);
    std::memcpy(line.data(), text.data(), length);
    line[length] = '\n';
    line[length + 1] = '\0';
    now_ = next;
  }
  void say() const {
    const char* line = lines_[static_cast<std::size_t>(now_.load())].data();
    if (::write(STDERR_FILENO, line, std::strlen(line)) < 0) return;
  }

 private:
  std::array<std::array<char, 1024>, 2> lines_{};
  std::atomic<int> now_ = 0;
};

SharedLine first_line, second_line;
std::atomic<int> interrupts = 0;
std::atomic<int> held = 0, waiting = 0;  // HoldInterrupts that live; the signal that waits for them
std::atomic<double> first_at = 0;

double seconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void end_by(int signal) {
  second_line.say();
  remove_held_lock();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void handle(int signal) {
  const int error = errno;
  if (interrupts == 0) {
    first_at = seconds();
    interrupts = 1;
    first_line.say();
  } else if (signal != SIGPIPE && seconds() - first_at >= kSamePress) {
    if (held > 0)
      waiting = signal;
    else
      end_by(signal);
  }
  errno = error;
}

}  // namespace

Interrupts::Interrupts(const std::string& first, const std::string& second) {
  interrupts = 0;
  waiting = 0;
  set_lines(first, second);
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    before_[i] = std::signal(kSignals[i], handle);
    if (before_[i] == SIG_IGN) std::signal(kSignals[i], SIG_IGN);
  }
}

void Interrupts::ignore() {
  before_.fill(SIG_IGN);
  for (const int signal : kSignals) std::signal(signal, SIG_IGN);
}

Interrupts::~Interrupts() {
  if (any()) return;  // the program is ending: the other half of the press shall not kill it
  for (std::size_t i = 0; i < kSignals.size(); ++i) std::signal(kSignals[i], before_[i]);
}

bool Interrupts::any() const { return interrupts > 0; }

void Interrupts::set_lines(const std::string& first, const std::string& second) {
  // Over the bar of a terminal
  const std::string begin = isatty(STDERR_FILENO) != 0 ? "\r\x1b[K" : "";
  first_line.set(begin + first);
  second_line.set(begin + second);
}

HoldInterrupts::HoldInterrupts() { ++held; }

HoldInterrupts::~HoldInterrupts() {
  if (--held == 0 && waiting != 0) end_by(waiting);
}

}  // namespace fluxgs::cli
