#include "trainer/core/process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <system_error>
#include <utility>

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

constexpr int kNotStarted = 127;

/// A file descriptor, closed in other programs and with this object.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor() { close(); }
  void close() {
    if (number_ >= 0) ::close(std::exchange(number_, -1));
  }
  int number() const { return number_; }

 private:
  int number_;
};

Descriptor open_file(const fs::path& path, int flags) {
  return Descriptor(::open(path.c_str(), flags | O_CLOEXEC, 0644));
}

/// Standard streams of a new process, opened before it starts.
struct Streams {
  Descriptor in, out, errors;
};

/// Between fork and exec only calls are allowed that a signal handler may make.
[[noreturn]] void become(const char* program, char* const* argv, const Streams& streams,
                         pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kNotStarted);  // It died before
  const std::array<int, 3> from{streams.in.number(), streams.out.number(), streams.errors.number()};
  for (int stream = 0; stream < 3; ++stream)
    if (dup2(from[static_cast<std::size_t>(stream)], stream) < 0) _exit(kNotStarted);
  execv(program, argv);
  _exit(kNotStarted);
}

pid_t start(const Process& process, const Streams& streams) {
  std::vector<std::string> words{process.program.string()};
  words.insert(words.end(), process.arguments.begin(), process.arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t parent = getpid(), child = fork();
  if (child == 0) become(process.program.c_str(), argv.data(), streams, parent);
  return child;
}

ProcessEnd wait_for(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return {};
  if (WIFSIGNALED(status)) return {.status = -1, .signal = WTERMSIG(status)};
  return {.status = WEXITSTATUS(status) == kNotStarted ? -1 : WEXITSTATUS(status)};
}

void read_all(int descriptor, const OutputSink& sink) {
  std::vector<char> buffer(1 << 16);
  for (;;) {
    const ssize_t count = ::read(descriptor, buffer.data(), buffer.size());
    if (count > 0) sink({buffer.data(), static_cast<std::size_t>(count)});
    if (count == 0 || (count < 0 && errno != EINTR)) return;
  }
}

constexpr int kAppend = O_WRONLY | O_CREAT | O_APPEND, kReplace = O_WRONLY | O_CREAT | O_TRUNC;

}  // namespace

std::string ProcessEnd::text() const {
  if (signal > 0) return "was killed by signal " + std::to_string(signal);
  return status < 0 ? "could not be started" : "ended with status " + std::to_string(status);
}

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
  const auto output = [&] {
    return process.output.empty() ? open_file(process.log, kAppend)
                                  : open_file(process.output, kReplace);
  };
  const pid_t child =
      start(process, {open_file("/dev/null", O_RDONLY), output(), open_file(process.log, kAppend)});
  return child < 0 ? -1 : wait_for(child).status;
}

ProcessEnd run(const Process& process, const OutputSink& sink, Captured captured) {
  std::array<int, 2> pipe_ends{-1, -1};
  if (pipe2(pipe_ends.data(), O_CLOEXEC) != 0) return {};
  const Descriptor reader(pipe_ends[0]);
  Streams streams{open_file("/dev/null", O_RDONLY), Descriptor(pipe_ends[1]), Descriptor()};
  streams.errors = captured == Captured::output
                       ? open_file(process.log, kAppend)
                       : Descriptor(fcntl(pipe_ends[1], F_DUPFD_CLOEXEC, 0));
  const pid_t child = start(process, streams);
  streams.out.close();
  streams.errors.close();
  if (child < 0) return {};
  read_all(reader.number(), sink);
  return wait_for(child);
}

}  // namespace fluxgs
