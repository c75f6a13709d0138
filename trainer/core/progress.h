// Progress of long work, counted by the library and shown by the command.
#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace fluxgs {

/// Called now and then, never by two threads at once; `done` grows up to `total`. May be empty.
using ProgressReport = std::function<void(std::size_t done, std::size_t total)>;

/// The same for work of several steps: `step` says what is done, `unit` what is counted.
using StepReport = std::function<void(const std::string& step, const std::string& unit,
                                      std::size_t done, std::size_t total)>;

/// Counts what several threads finish.
class ProgressCounter {
 public:
  ProgressCounter(const ProgressReport& report, std::size_t total)
      : report_(report), total_(total) {}

  void add_one() {
    if (!report_) return;
    const std::lock_guard lock(mutex_);
    report_(++done_, total_);
  }

 private:
  const ProgressReport& report_;
  std::mutex mutex_;
  std::size_t done_ = 0, total_;
};

/// One progress over parts of work that follow each other. Each has a share: the time that it
/// takes, in any unit.
class ProgressParts {
 public:
  ProgressParts(ProgressReport report, std::vector<double> shares)
      : report_(std::move(report)), shares_(std::move(shares)) {}

  /// The progress of part `i`. This must outlive it.
  ProgressReport part(std::size_t i) const {
    if (!report_) return {};
    return [this, i](std::size_t done, std::size_t total) {
      const auto middle = shares_.begin() + static_cast<std::ptrdiff_t>(i);
      const double before = std::accumulate(shares_.begin(), middle, 0.0);
      const double all = std::accumulate(middle, shares_.end(), before);
      const double now =
          total > 0 ? static_cast<double>(done) / static_cast<double>(total) * shares_[i] : 0;
      report_(static_cast<std::size_t>(kSteps * (before + now) / all), kSteps);
    };
  }

 private:
  static constexpr std::size_t kSteps = 1000;
  ProgressReport report_;
  std::vector<double> shares_;
};

/// Long work as its caller follows it. Both may be empty.
struct WorkControl {
  ProgressReport progress = {};
  std::function<bool()> stop = {};  ///< true: the work ends as soon as it can, without a result

  bool stopped() const { return stop && stop(); }
};

}  // namespace fluxgs
