#include "tools/fluxgs/child_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

#include <fmt/format.h>

#include "trainer/core/clock.h"

extern char** environ;

namespace fluxgs::cli {
namespace {

/// Where the child's standard streams go; released with it.
class Streams {
 public:
  explicit Streams(const ChildProcess& child) {
    posix_spawn_file_actions_init(&actions_);
    constexpr int kAppend = O_WRONLY | O_CREAT | O_APPEND, kReplace = O_WRONLY | O_CREAT | O_TRUNC;
    open(STDIN_FILENO, "/dev/null", O_RDONLY);
    open(STDERR_FILENO, child.log.c_str(), kAppend);
    if (child.output.empty())
      posix_spawn_file_actions_adddup2(&actions_, STDERR_FILENO, STDOUT_FILENO);
    else
      open(STDOUT_FILENO, child.output.c_str(), kReplace);
  }
  ~Streams() { posix_spawn_file_actions_destroy(&actions_); }
  Streams(const Streams&) = delete;
  Streams& operator=(const Streams&) = delete;

  const posix_spawn_file_actions_t* actions() const { return &actions_; }

 private:
  void open(int stream, const char* path, int flags) {
    posix_spawn_file_actions_addopen(&actions_, stream, path, flags, 0644);
  }
  posix_spawn_file_actions_t actions_{};
};

Expected<pid_t> start(const ChildProcess& child) {
  std::vector<std::string> words{child.program.filename().string()};
  words.insert(words.end(), child.arguments.begin(), child.arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const Streams streams(child);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  pid_t pid = 0;
  const int error = posix_spawn(&pid, child.program.c_str(), streams.actions(), &attributes,
                                argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  if (error != 0)
    return fail(child.program.string(), "",
                fmt::format("cannot be started, or {} not be written: {}", child.log.string(),
                            std::strerror(error)));
  return pid;
}

double seconds_of(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

}  // namespace

Expected<ChildEnd> run_child(const ChildProcess& child, const InterruptCounter* interrupts,
                             const std::function<void()>& while_waiting) {
  int passed_on = 0;  // also what came before it could be started
  const double begin = wall_seconds();
  const auto pid = start(child);
  if (!pid) return std::unexpected(pid.error());
  for (;;) {
    int status = 0;
    rusage usage{};
    const pid_t ended = wait4(*pid, &status, WNOHANG, &usage);
    if (ended == *pid)
      return ChildEnd{.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1,
                      .signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0,
                      .seconds = wall_seconds() - begin,
                      .cpu_seconds = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime)};
    if (ended < 0 && errno != EINTR)
      return fail(child.program.string(), "", fmt::format("was lost: {}", std::strerror(errno)));
    for (; interrupts && passed_on < interrupts->count(); ++passed_on) kill(*pid, SIGINT);
    if (while_waiting) while_waiting();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

}  // namespace fluxgs::cli
