// Another run of this program, beside it.
#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

namespace fluxgs::cli {

/// Runs this program with other arguments. Ctrl-C in the terminal does not reach it; it ends with
/// this object, and with this process.
class ChildProcess {
 public:
  /// Standard input and output are closed to it; standard error is shared.
  explicit ChildProcess(const std::vector<std::string>& arguments);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// False once it has ended, or where it could not be started.
  bool runs();

 private:
  pid_t process_ = -1;
};

}  // namespace fluxgs::cli
