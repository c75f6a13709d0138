// Ctrl-C, kill, a closed terminal and a closed pipe, noticed by work that wants to end in its own
// way.
#pragma once

#include <array>
#include <csignal>
#include <string>

namespace fluxgs::cli {

/// Signals that ask the program to end.
inline constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP, SIGPIPE};

/// While it lives, the first of these signals says a line and is counted; a second one says another
/// and ends the program. Signals within half a second are one: people press twice. Signals that are
/// ignored (nohup) stay so. A closed pipe counts once only. After a signal, that goes on when this
/// is gone. One at a time in a process.
class Interrupts {
 public:
  /// The lines of set_lines(), said from the start.
  explicit Interrupts(const std::string& first = "interrupted",
                      const std::string& second = "interrupted");
  ~Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;

  bool any() const;
  /// The lines of the next signals, without line ends; at most 1,000 bytes each are said.
  void set_lines(const std::string& first, const std::string& second);
  /// For the end of the program, when all is done: signals are not heard any more.
  void ignore();

 private:
  std::array<void (*)(int), kSignals.size()> before_{};
};

/// Lets what goes on end first, such as the writing of a file: a second signal ends the program
/// only when this goes.
class HoldInterrupts {
 public:
  HoldInterrupts();
  ~HoldInterrupts();
  HoldInterrupts(const HoldInterrupts&) = delete;
  HoldInterrupts& operator=(const HoldInterrupts&) = delete;
};

}  // namespace fluxgs::cli
