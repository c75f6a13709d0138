#include "tools/fluxgs/terminal/child_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

namespace fluxgs::cli {

ChildProcess::ChildProcess(const std::vector<std::string>& arguments) {
  std::string program = "fluxgs";
  std::vector<char*> words{program.data()};
  std::vector<std::string> copies = arguments;
  for (std::string& word : copies) words.push_back(word.data());
  words.push_back(nullptr);
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  const pid_t parent = ::getpid();
  process_ = ::fork();
  if (process_ == 0) {
    // Between fork() and exec() only what a signal handler may do: other threads hold locks
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != parent) ::_exit(126);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::signal(signal, SIG_DFL);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO})
      if (nothing >= 0) ::dup2(nothing, stream);
    ::execv("/proc/self/exe", words.data());
    ::_exit(127);
  }
  if (nothing >= 0) ::close(nothing);
}

bool ChildProcess::runs() {
  if (process_ <= 0) return false;
  if (::waitpid(process_, nullptr, WNOHANG) == 0) return true;
  process_ = -1;
  return false;
}

ChildProcess::~ChildProcess() {
  if (!runs()) return;
  ::kill(process_, SIGTERM);
  ::waitpid(process_, nullptr, 0);
}

}  // namespace fluxgs::cli
