// The lock of a result under signals that come at any moment.
#include "tools/fluxgs/terminal/run_lock.h"

#include <gtest/gtest.h>

#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "support/temp_folder.h"

namespace fluxgs::cli {
namespace {

void end(int) {
  remove_held_lock();
  ::_exit(0);
}

/// Takes and gives back a lock until a signal comes, after some microseconds.
[[noreturn]] void lock_until_a_signal(const std::string& out, int microseconds) {
  std::signal(SIGALRM, end);
  const itimerval soon{{0, 0}, {0, microseconds}};
  ::setitimer(ITIMER_REAL, &soon, nullptr);
  for (;;)
    if (const auto lock = RunLock::take(out); !lock) ::_exit(1);
}

TEST(RunLock, ASignalAtAnyMomentLeavesNoFileBehind) {
  const test::TempFolder folder;
  const std::string out = (folder / "scene.glb").string();
  for (int trial = 1; trial <= 200; ++trial) {
    const pid_t child = ::fork();
    if (child == 0) lock_until_a_signal(out, 100 + 7 * trial);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_EQ(status, 0);
    ASSERT_FALSE(std::filesystem::exists(out + ".lock")) << "trial " << trial;
  }
}

}  // namespace
}  // namespace fluxgs::cli
