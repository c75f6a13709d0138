// Other programs: finds them and runs them to their end.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
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

/// Runs a program to its end, without standard input. Returns its exit status, or -1 if it could
/// not be started or a signal ended it.
int run(const Process& process);

}  // namespace fluxgs
