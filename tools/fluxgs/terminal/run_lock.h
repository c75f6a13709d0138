// Lock of a result, so that two programs do not write the same one.
#pragma once

#include <string>

#include "fluxgs/error.h"

namespace fluxgs::cli {

/// Holds OUT.lock, which contains the number of this process, until it is destroyed. The lock is
/// the kernel's (flock): one that a killed program left behind is free. Where the file system has
/// no locks there are none.
class RunLock {
 public:
  /// An error names the process that holds the lock.
  static Expected<RunLock> take(const std::string& out);

  RunLock(RunLock&& other) noexcept;
  RunLock& operator=(RunLock&& other) = delete;
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;
  ~RunLock();

 private:
  RunLock(std::string path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::string path_;
  int descriptor_ = -1;
};

/// Removes the file of the lock that this process holds, if any: for the handler of a signal that
/// ends it.
void remove_held_lock();

}  // namespace fluxgs::cli
