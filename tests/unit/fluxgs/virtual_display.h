// An X server without a screen, for windows in tests.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <string>

namespace fluxgs::test {

/// Runs Xvfb on a display that it finds free, for as long as this lives.
class VirtualDisplay {
 public:
  /// `size` as WIDTHxHEIGHT.
  explicit VirtualDisplay(const std::string& size) {
    int ends[2];
    if (pipe(ends) != 0) return;
    process_ = fork();
    if (process_ == 0) {
      close(ends[0]);
      const std::string screen = size + "x24", number = std::to_string(ends[1]);
      // Its own log would end up between the lines of the tests
      if (freopen("/dev/null", "w", stderr) == nullptr) _exit(126);
      execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", screen.c_str(),
             "-nolisten", "tcp", nullptr);
      _exit(127);
    }
    close(ends[1]);
    char digit = 0;
    // Nothing comes where there is no Xvfb
    while (read(ends[0], &digit, 1) == 1 && digit != '\n') number_ += digit;
    close(ends[0]);
  }
  ~VirtualDisplay() {
    if (process_ <= 0) return;
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }
  VirtualDisplay(const VirtualDisplay&) = delete;
  VirtualDisplay& operator=(const VirtualDisplay&) = delete;

  bool available() const { return !number_.empty(); }
  /// ":99", for the environment's DISPLAY.
  std::string name() const { return ":" + number_; }

 private:
  pid_t process_ = -1;
  std::string number_;
};

}  // namespace fluxgs::test
