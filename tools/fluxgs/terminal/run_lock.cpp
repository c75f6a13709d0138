#include "tools/fluxgs/terminal/run_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace fluxgs::cli {
namespace {

/// The path of the lock that is held, for signal handlers; empty: none.
std::array<char, 4096> held_path{};

/// While it lives, signals wait: one that came between the file and held_path would leave the file
/// behind, or remove that of another process. For a time without other threads, which would be
/// given the signals.
class BlockSignals {
 public:
  BlockSignals() {
    sigset_t all;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~BlockSignals() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockSignals(const BlockSignals&) = delete;
  BlockSignals& operator=(const BlockSignals&) = delete;

 private:
  sigset_t before_{};
};

void hold(const std::string& path) {
  if (path.size() < held_path.size()) std::ranges::copy(path + '\0', held_path.begin());
}

/// The number in a lock file, for the message.
std::string holder(int descriptor) {
  std::array<char, 16> text{};
  const auto size = ::pread(descriptor, text.data(), text.size() - 1, 0);
  std::string digits;
  for (ssize_t i = 0; i < size && text[static_cast<std::size_t>(i)] >= '0' &&
                      text[static_cast<std::size_t>(i)] <= '9';
       ++i)
    digits += text[static_cast<std::size_t>(i)];
  return digits.empty() ? "another process" : "process " + digits;
}

/// True if the file is still the one under that name: who held it before may have removed it.
bool is_current(int descriptor, const std::string& path) {
  struct stat opened{}, named{};
  return ::fstat(descriptor, &opened) == 0 && ::stat(path.c_str(), &named) == 0 &&
         opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
}

}  // namespace

Expected<RunLock> RunLock::take(const std::string& out) {
  const std::string path = out + ".lock";
  const BlockSignals block;
  for (;;) {
    const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, mode_t{0666});
    if (file < 0) return fail(path, "write", std::generic_category().message(errno));
    if (::flock(file, LOCK_EX | LOCK_NB) != 0) {
      if (errno == EINTR) {
        ::close(file);
        continue;
      }
      const bool taken = errno == EWOULDBLOCK;
      const std::string by = holder(file);
      ::close(file);
      if (!taken) return RunLock(path, -1);  // the file system has none
      return fail(out, "",
                  fmt::format("is being written by {}; choose another name, or stop it", by));
    }
    if (is_current(file, path)) {
      const std::string text = fmt::format("{}\n", ::getpid());
      if (::ftruncate(file, 0) != 0 || ::pwrite(file, text.data(), text.size(), 0) < 0) {
        // A full disk: the lock holds without the number
      }
      hold(path);
      return RunLock(path, file);
    }
    ::close(file);
  }
}

RunLock::RunLock(RunLock&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

RunLock::~RunLock() {
  if (descriptor_ < 0) return;
  const BlockSignals block;
  held_path[0] = '\0';
  ::unlink(path_.c_str());
  ::close(descriptor_);
}

void remove_held_lock() {
  if (held_path[0] != '\0') ::unlink(held_path.data());
}

}  // namespace fluxgs::cli
