// Wall-clock time by named part of the program, without double counting.
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fluxgs {

class ProfileScope;

/// Seconds by name, in the order in which the names came up. No second is counted twice. For one
/// thread at a time.
class Profiler {
 public:
  using Entries = std::vector<std::pair<std::string, double>>;

  /// The time of a part, 0 before its first scope.
  double& operator[](std::string_view name) {
    for (auto& [known, seconds] : entries_)
      if (known == name) return seconds;
    return entries_.emplace_back(name, 0.0).second;
  }
  const Entries& entries() const { return entries_; }
  void clear() {
    for (auto& entry : entries_) entry.second = 0;
  }

 private:
  friend class ProfileScope;
  Entries entries_;
  ProfileScope* running_ = nullptr;
};

/// Adds its own lifetime to a part, without that of scopes made and gone meanwhile. `name` must
/// outlive it.
class ProfileScope {
 public:
  ProfileScope(Profiler& profiler, std::string_view name)
      : profiler_(profiler), outer_(profiler.running_), name_(name) {
    if (outer_) outer_->stop();
    profiler_.running_ = this;
  }
  ~ProfileScope() {
    stop();
    profiler_.running_ = outer_;
    if (outer_) outer_->start_ = Clock::now();
  }
  ProfileScope(const ProfileScope&) = delete;
  ProfileScope& operator=(const ProfileScope&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  void stop() { profiler_[name_] += std::chrono::duration<double>(Clock::now() - start_).count(); }

  Profiler& profiler_;
  ProfileScope* outer_;
  std::string_view name_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace fluxgs
