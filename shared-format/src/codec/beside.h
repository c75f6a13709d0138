// Work on a second thread while the caller does other work.
#pragma once

#include <exception>
#include <optional>
#include <system_error>
#include <thread>
#include <type_traits>
#include <utility>

namespace fluxgs::codec {

#if defined(__EMSCRIPTEN__) && !defined(__EMSCRIPTEN_PTHREADS__)
constexpr bool kHasThreads = false;
#else
constexpr bool kHasThreads = true;
#endif

/// Work that returns a value, done on a thread of its own, or by result() where there is none. Not
/// std::async: that of libc++ waits for ever where a thread cannot begin. What the work refers to
/// must outlive this.
template <class Work>
class Beside {
 public:
  /// On a thread only if the work is `long_enough` to be worth one.
  Beside(bool long_enough, Work work) : work_(std::move(work)) {
    if constexpr (kHasThreads) {
      if (!long_enough) return;
      try {
        thread_ = std::thread([this] { run(); });
      } catch (const std::system_error&) {
        return;  // result() does it
      }
    }
  }
  Beside(const Beside&) = delete;
  Beside& operator=(const Beside&) = delete;
  ~Beside() {
    if (thread_.joinable()) thread_.join();
  }

  /// Waits for it. To be called once; throws what the work has thrown.
  std::invoke_result_t<Work&> result() {
    if (thread_.joinable())
      thread_.join();
    else
      run();
    if (thrown_) std::rethrow_exception(thrown_);
    return std::move(*value_);
  }

 private:
  void run() {
    try {
      value_.emplace(work_());
    } catch (...) {
      thrown_ = std::current_exception();
    }
  }

  Work work_;
  std::optional<std::invoke_result_t<Work&>> value_;
  std::exception_ptr thrown_;
  std::thread thread_;
};

}  // namespace fluxgs::codec
