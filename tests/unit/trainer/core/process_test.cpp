// Other programs: what they say, how they end, and that they end with us.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "support/temp_folder.h"
#include "trainer/core/process.h"

namespace fluxgs {
namespace {

Process shell(const std::string& script, const std::filesystem::path& log = "/dev/null") {
  return {"/bin/sh", {"-c", script}, log};
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(Process, StatusSignalAndMissingProgram) {
  const auto end_of = [](const Process& p) {
    return run(p, [](std::string_view) {}, Captured::output);
  };
  EXPECT_EQ(run(shell("exit 3")), 3);
  EXPECT_EQ(end_of(shell("exit 0")).status, 0);
  EXPECT_EQ(end_of(shell("exit 3")).text(), "ended with status 3");
  EXPECT_EQ(end_of(shell("kill -9 $$")).text(), "was killed by signal 9");
  EXPECT_EQ(end_of({"/nowhere/program", {}, "/dev/null"}).text(), "could not be started");
  EXPECT_EQ(run({"/nowhere/program", {}, "/dev/null"}), -1);
}

TEST(Process, OutputAndErrors) {
  const test::TempFolder folder;
  std::string got;
  const auto sink = [&](std::string_view text) { got += text; };
  run(shell("echo out; echo err >&2", folder / "log"), sink, Captured::output);
  EXPECT_EQ(got, "out\n");
  EXPECT_EQ(text_of(folder / "log"), "err\n");
  got.clear();
  run(shell("echo out; echo err >&2", folder / "log"), sink, Captured::output_and_errors);
  EXPECT_EQ(got, "out\nerr\n");
  EXPECT_EQ(run(shell("cat; echo more >&2", folder / "log")), 0) << "no standard input to wait for";
  EXPECT_EQ(text_of(folder / "log"), "err\nmore\n");
  got.clear();
  run(shell("head -c 3000000 /dev/zero"), sink, Captured::output);
  EXPECT_EQ(got.size(), 3'000'000u);
}

bool is_running(pid_t pid) {
  const std::string stat = text_of("/proc/" + std::to_string(pid) + "/stat");
  return !stat.empty() && stat.find(") Z") == std::string::npos;
}

/// Waits some seconds for a condition.
template <class Condition>
bool comes_true(const Condition& condition) {
  for (int i = 0; i < 1000 && !condition(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return condition();
}

TEST(Process, DiesWithUsWhateverEndsUs) {
  for (const int signal : {SIGINT, SIGTERM, SIGKILL}) {
    const test::TempFolder folder;
    const std::string note = (folder / "pid").string();
    const pid_t us = fork();
    if (us == 0) {
      ::signal(signal, SIG_DFL);
      run(shell("echo $$ > " + note + ".part; mv " + note + ".part " + note + "; exec sleep 600"));
      _exit(0);
    }
    ASSERT_TRUE(comes_true([&] { return std::filesystem::exists(note); }));
    const pid_t program = std::stoi(text_of(note));
    EXPECT_TRUE(is_running(program));
    kill(us, signal);
    waitpid(us, nullptr, 0);
    EXPECT_TRUE(comes_true([&] { return !is_running(program); })) << "signal " << signal;
  }
}

}  // namespace
}  // namespace fluxgs
