// Other programs, and this one once more, run to their end beside us.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "tools/fluxgs/interrupt.h"

namespace fluxgs::cli {

struct ChildProcess {
  std::filesystem::path program;       ///< a file; nothing is looked up on the PATH
  std::vector<std::string> arguments;  ///< without the program's own name; no shell sees them
  std::filesystem::path log;           ///< standard error is appended here
  std::filesystem::path output;  ///< standard output replaces this; empty: goes to the log too
};

struct ChildEnd {
  int status = 0;                       ///< what it returned; meaningless if a signal ended it
  int signal = 0;                       ///< that ended it, or 0
  double seconds = 0, cpu_seconds = 0;  ///< wall and processor time, from its start to its end

  bool success() const { return signal == 0 && status == 0; }
};

/// Runs it to its end, with `while_waiting` called about twenty times a second. Each interrupt, if
/// they are counted, is passed on as SIGINT; it is up to the child what becomes of it. The child
/// has a process group of its own, so that Ctrl-C on a terminal does not reach it a second time.
/// Errors: it cannot be started.
Expected<ChildEnd> run_child(const ChildProcess& child, const InterruptCounter* interrupts,
                             const std::function<void()>& while_waiting = {});

}  // namespace fluxgs::cli
