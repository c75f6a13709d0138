// Times of the same thing taken again and again, in numbers that can be compared.
#pragma once

#include <chrono>
#include <vector>

namespace fluxgs::bench {

struct Summary {
  double mean = 0, median = 0, p95 = 0, least = 0;
};

/// All zeros for no samples. The median of an even number is the mean of the middle two; p95 is the
/// smallest sample that at least 95% of all do not exceed.
Summary summarize(std::vector<double> samples);

/// Milliseconds that pass while `work` runs.
template <class Work>
double milliseconds_of(Work&& work) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  work();
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace fluxgs::bench
