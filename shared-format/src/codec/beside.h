// Work on a second thread while the caller does other work.
#pragma once

#include <future>
#include <system_error>
#include <thread>
#include <utility>

namespace fluxgs::codec {

/// Work that returns a Result, done on a thread of its own, or by result() where there is none, as
/// in browsers. Not std::async: that of libc++ waits for ever where a thread cannot begin. What the
/// work refers to must outlive this.
template <class Result>
class Beside {
 public:
  /// On a thread only if the work is `long_enough` to be worth one.
  template <class Work>
  Beside(bool long_enough, Work work) : task_(std::move(work)), result_(task_.get_future()) {
    if (!long_enough) return;
    try {
      thread_ = std::thread([this] { task_(); });
    } catch (const std::system_error&) {
      return;  // result() does it
    }
  }
  Beside(const Beside&) = delete;
  Beside& operator=(const Beside&) = delete;
  ~Beside() {
    if (thread_.joinable()) thread_.join();
  }

  /// Waits for it. To be called once; throws what the work has thrown.
  Result result() {
    if (!thread_.joinable()) task_();
    return result_.get();
  }

 private:
  std::packaged_task<Result()> task_;
  std::future<Result> result_;
  std::thread thread_;
};

}  // namespace fluxgs::codec
