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
      terminal_(isatty(STDERR_FILENO)),
      start_{Clock::now(), done},
      last_(start_),
      middle_(start_),
      early_(start_) {}

bool Progress::due() const {
  const double since = std::chrono::duration<double>(Clock::now() - last_.time).count();
  return since >= (terminal_ ? kTerminalInterval : kPlainInterval);
}

std::string Progress::line(int done, const std::string& detail, double left) const {
  const int filled =
      static_cast<int>(static_cast<long long>(kBarWidth) * done / std::max(total_, 1));
  std::string bar(static_cast<std::size_t>(std::clamp(filled, 0, kBarWidth)), '#');
  bar.resize(kBarWidth, '.');
  const std::string count = unit_.empty()
                                ? fmt::format("{:.0f}%", 100.0 * done / std::max(total_, 1))
                                : fmt::format("{}/{}  {:.1f} {}/s", done, total_, rate_, unit_);
  return fmt::format("[{}] {}  {}{}{} left", bar, count, detail, detail.empty() ? "" : "  ",
                     duration(left));
}

/// By the rate since a mark that lies between half and three quarters of the time back.
double Progress::seconds_left(const Mark& now) {
  if (now.time - middle_.time > middle_.time - start_.time) early_ = middle_, middle_ = now;
  const double seconds = std::chrono::duration<double>(now.time - early_.time).count();
  const int done = now.done - early_.done;
  return done > 0 ? seconds * (total_ - now.done) / done : 0;
}

void Progress::update(int done, const std::string& detail, std::optional<double> seconds_left) {
  if (!due()) return;
  const Mark now{Clock::now(), std::max(done, last_.done)};
  const double recent =
      (now.done - last_.done) / std::chrono::duration<double>(now.time - last_.time).count();
  rate_ = rate_ > 0 && terminal_ ? 0.8 * rate_ + 0.2 * recent : recent;
  const double by_rate = this->seconds_left(now);
  last_ = now;
  shown_ = true;
  const std::string text = line(now.done, detail, seconds_left.value_or(by_rate));
  if (terminal_)
    say("\r\x1b[K" + text);
  else
    say(text + "\n");
}

void Progress::clear(const std::string& detail) const {
  if (terminal_)
    say("\r\x1b[K");
  else if (shown_)
    say(line(total_, detail, 0) + "\n");
}

void Progress::finish(int done) const {
  if (terminal_) say("\r\x1b[K");
  const double seconds = std::chrono::duration<double>(Clock::now() - start_.time).count();
  say(fmt::format("{} iterations in {} ({:.1f} {}/s)\n", done - start_.done, duration(seconds),
                  seconds > 0 ? (done - start_.done) / seconds : 0.0, unit_));
}

namespace {

ProgressReport shown_as(const std::string& unit, const std::string& detail) {
  return [=, bar = std::shared_ptr<Progress>()](std::size_t done, std::size_t total) mutable {
    if (!bar) bar = std::make_shared<Progress>(unit, static_cast<int>(total), 0);
    if (done < total)
      bar->update(static_cast<int>(done), detail);
    else
      bar->clear(detail);
  };
}

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

ProgressReport show_progress(const std::string& unit) { return shown_as(unit, ""); }

ProgressReport show_work(const std::string& name) { return shown_as("", name); }

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
