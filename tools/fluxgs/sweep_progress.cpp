#include "tools/fluxgs/sweep_progress.h"

#include <unistd.h>

#include <algorithm>

#include <fmt/format.h>

#include "tools/fluxgs/console.h"
#include "tools/fluxgs/progress.h"

namespace fluxgs::cli {
namespace {

constexpr double kPlainInterval = 60;  // seconds

}  // namespace

SweepProgress::SweepProgress(int runs, double iterations)
    : runs_(runs), left_(iterations), terminal_(isatty(STDERR_FILENO)) {}

double SweepProgress::seconds_since(Clock::time_point then) const {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

void SweepProgress::begin(const std::string& name, int iterations) {
  ++number_;
  left_ -= iterations;
  name_ = name;
  iterations_ = iterations;
  first_ = -1;
  begin_ = said_ = Clock::now();
}

void SweepProgress::update(int iteration) {
  // A checkpoint's iterations took no time now
  if (first_ < 0 && iteration > 0) first_ = iteration;
  if (!terminal_ && seconds_since(said_) < kPlainInterval) return;
  said_ = Clock::now();
  const int now = first_ < 0 ? 0 : iteration - first_;
  const double seconds = spent_ + seconds_since(begin_);
  const double rate = seconds > 0 ? (trained_ + now) / seconds : 0;
  const std::string left =
      rate > 0 ? fmt::format("{} left", duration((left_ + iterations_ - iteration) / rate)) : "";
  say(fmt::format("{}[{}/{} runs] {}: {}/{}  {:.1f} it/s  {}{}", terminal_ ? "\r\x1b[K" : "",
                  number_, runs_, name_, iteration, iterations_, rate, left,
                  terminal_ ? "" : "\n"));
}

void SweepProgress::end(bool ran, const std::string& line) {
  if (ran) {
    trained_ += iterations_ - std::max(first_, 0);
    spent_ += seconds_since(begin_);
  }
  if (terminal_) say("\r\x1b[K");
  if (!line.empty()) say(fmt::format("[{}/{} runs] {}: {}\n", number_, runs_, name_, line));
}

}  // namespace fluxgs::cli
