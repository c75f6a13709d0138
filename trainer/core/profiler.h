// Time by named part of the program, without double counting: wall clock and processor.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "trainer/core/clock.h"

namespace fluxgs {

class ProfileScope;

/// Seconds by name, in the order in which the names came up. No second is counted twice. For one
/// thread at a time.
class Profiler {
 public:
  using Entries = std::vector<std::pair<std::string, double>>;

  /// The wall-clock time of a part, 0 before its first scope.
  double& operator[](std::string_view name) { return of(entries_, name); }
  const Entries& entries() const { return entries_; }  ///< wall clock
  /// Processor time of all threads, which says more on a machine that others use, too.
  const Entries& cpu_entries() const { return cpu_entries_; }
  void clear() {
    for (Entries* all : {&entries_, &cpu_entries_})
      for (auto& entry : *all) entry.second = 0;
  }

 private:
  friend class ProfileScope;
  static double& of(Entries& entries, std::string_view name) {
    for (auto& [known, seconds] : entries)
      if (known == name) return seconds;
    return entries.emplace_back(name, 0.0).second;
  }

  Entries entries_, cpu_entries_;
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
    start();
  }
  ~ProfileScope() {
    stop();
    profiler_.running_ = outer_;
    if (outer_) outer_->start();
  }
  ProfileScope(const ProfileScope&) = delete;
  ProfileScope& operator=(const ProfileScope&) = delete;

 private:
  void start() { start_ = wall_seconds(), cpu_start_ = cpu_seconds(); }
  void stop() {
    Profiler::of(profiler_.entries_, name_) += wall_seconds() - start_;
    Profiler::of(profiler_.cpu_entries_, name_) += cpu_seconds() - cpu_start_;
  }

  Profiler& profiler_;
  ProfileScope* outer_;
  std::string_view name_;
  double start_ = 0, cpu_start_ = 0;
};

}  // namespace fluxgs
