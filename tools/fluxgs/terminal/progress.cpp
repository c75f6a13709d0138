#include "tools/fluxgs/terminal/progress.h"

#include <unistd.h>

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "tools/fluxgs/terminal/console.h"

namespace fluxgs::cli {
namespace {

constexpr double kTerminalInterval = 0.25, kPlainInterval = 10;  // seconds
constexpr int kBarWidth = 24;

}  // namespace

std::string duration(double seconds) {
  const long s = static_cast<long>(std::clamp(seconds, 0.0, 3599999.0));
  return s >= 3600 ? fmt::format("{}h{:02}m", s / 3600, s / 60 % 60)
                   : fmt::format("{}m{:02}s", s / 60, s % 60);
}

Progress::Progress(std::string unit, int total, int done)
    : unit_(std::move(unit)),
      total_(total),
      first_(done),
      terminal_(isatty(STDERR_FILENO)),
      start_(Clock::now()),
      last_(start_),
      last_done_(done) {}

bool Progress::due() const {
  const double since = std::chrono::duration<double>(Clock::now() - last_).count();
  return since >= (terminal_ ? kTerminalInterval : kPlainInterval);
}

std::string Progress::line(int done, const std::string& detail) const {
  const int filled =
      static_cast<int>(static_cast<long long>(kBarWidth) * done / std::max(total_, 1));
  const double left = rate_ > 0 ? (total_ - done) / rate_ : 0;
  std::string bar(static_cast<std::size_t>(filled), '#');
  bar.resize(kBarWidth, '.');
  return fmt::format("[{}] {}/{}  {:.1f} {}/s  {}{}{} left", bar, done, total_, rate_, unit_,
                     detail, detail.empty() ? "" : "  ", duration(left));
}

void Progress::update(int done, const std::string& detail) {
  if (!due()) return;
  const Clock::time_point now = Clock::now();
  const double recent = (done - last_done_) / std::chrono::duration<double>(now - last_).count();
  rate_ = rate_ > 0 && terminal_ ? 0.8 * rate_ + 0.2 * recent : recent;
  last_ = now;
  last_done_ = done;
  if (terminal_)
    say("\r\x1b[K" + line(done, detail));
  else
    say(line(done, detail) + "\n");
}

void Progress::clear() const {
  if (terminal_) say("\r\x1b[K");
}

void Progress::finish(int done) const {
  clear();
  const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  say(fmt::format("{} iterations in {} ({:.1f} {}/s)\n", done - first_, duration(seconds),
                  seconds > 0 ? (done - first_) / seconds : 0.0, unit_));
}

ProgressReport show_progress(const std::string& unit) {
  return [unit, bar = std::shared_ptr<Progress>()](std::size_t done, std::size_t total) mutable {
    if (!bar) bar = std::make_shared<Progress>(unit, static_cast<int>(total), 0);
    if (done < total)
      bar->update(static_cast<int>(done), "");
    else
      bar->clear();
  };
}

namespace {

/// The step that is under way.
struct ShownStep {
  using Clock = std::chrono::steady_clock;
  std::string name, unit;
  Progress bar;
  Clock::time_point start = Clock::now();

  void finish(std::size_t total) const {
    bar.clear();
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    say(fmt::format("{}: {} {} in {}\n", name, total, unit, duration(seconds)));
  }
};

}  // namespace

StepReport show_steps() {
  return [shown = std::shared_ptr<ShownStep>()](const std::string& step, const std::string& unit,
                                                std::size_t done, std::size_t total) mutable {
    if (done < total && (!shown || shown->name != step))
      shown = std::make_shared<ShownStep>(
          ShownStep{step, unit, Progress(unit, static_cast<int>(total), static_cast<int>(done))});
    if (!shown || shown->name != step) return;
    if (done < total) {
      shown->bar.update(static_cast<int>(done), step);
    } else {
      shown->finish(total);
      shown.reset();
    }
  };
}

}  // namespace fluxgs::cli
