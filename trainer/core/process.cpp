#include "trainer/core/process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <string_view>
#include <system_error>

extern char** environ;

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

/// Targets of the standard streams of a new process.
class Streams {
 public:
  explicit Streams(const Process& process) {
    posix_spawn_file_actions_init(&actions_);
    constexpr int kAppend = O_WRONLY | O_CREAT | O_APPEND, kReplace = O_WRONLY | O_CREAT | O_TRUNC;
    open(STDIN_FILENO, "/dev/null", O_RDONLY);
    open(STDERR_FILENO, process.log.c_str(), kAppend);
    if (process.output.empty())
      posix_spawn_file_actions_adddup2(&actions_, STDERR_FILENO, STDOUT_FILENO);
    else
      open(STDOUT_FILENO, process.output.c_str(), kReplace);
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

}  // namespace

std::optional<fs::path> find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::string_view rest = path ? path : "";
  while (!rest.empty()) {
    const std::string_view folder = rest.substr(0, rest.find(':'));
    rest.remove_prefix(std::min(folder.size() + 1, rest.size()));
    fs::path candidate = fs::path(folder) / name;
    std::error_code ignored;
    if (!folder.empty() && fs::is_regular_file(candidate, ignored) &&
        access(candidate.c_str(), X_OK) == 0)
      return candidate;
  }
  return std::nullopt;
}

int run(const Process& process) {
  std::vector<std::string> words{process.program.string()};
  words.insert(words.end(), process.arguments.begin(), process.arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const Streams streams(process);
  pid_t child = 0;
  if (posix_spawn(&child, process.program.c_str(), streams.actions(), nullptr, argv.data(),
                  environ) != 0)
    return -1;
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace fluxgs
