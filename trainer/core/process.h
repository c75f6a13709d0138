// Other programs: finds them and runs them to their end.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fluxgs {

/// The executable of that name on PATH, if any.
std::optional<std::filesystem::path> find_program(const std::string& name);

struct Process {
  std::filesystem::path program;       ///< a file; PATH is not searched
  std::vector<std::string> arguments;  ///< without the program's own name; no shell sees them
  std::filesystem::path log;           ///< standard error is appended here
  std::filesystem::path output = {};   ///< standard output replaces this; empty: goes to the log
};

/// End of a program.
struct ProcessEnd {
  int status = -1;  ///< exit status; −1: it did not start, or a signal ended it
  int signal = 0;   ///< that ended it
  /// "ended with status 1", "was killed by signal 9", "could not be started".
  std::string text() const;
};

/// Runs a program to its end, without standard input. Returns its exit status, or -1 if it could
/// not be started or a signal ended it. It dies with the calling thread, whatever ends that.
int run(const Process& process);

/// Receives what a program writes, piece by piece.
using OutputSink = std::function<void(std::string_view)>;
enum class Captured { output, output_and_errors };

/// The same, with standard output (and standard error, which then does not go to the log by itself)
/// given to `sink`. Process::output has no effect.
ProcessEnd run(const Process& process, const OutputSink& sink, Captured captured);

}  // namespace fluxgs
