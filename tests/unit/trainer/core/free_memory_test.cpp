#include "trainer/core/free_memory.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <optional>

#include "support/sanitized.h"
#include "support/temp_folder.h"

namespace fluxgs::test {
namespace {

void write(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file) << text;
}

TEST(FreeMemory, IsThatOfTheTightestGroup) {
  const TempFolder root;
  write(root / "memory.stat", "anon 5\n");
  write(root / "machine.slice/memory.max", "1000\n");
  write(root / "machine.slice/memory.current", "700\n");
  write(root / "machine.slice/memory.stat", "anon 400\ninactive_file 200\nactive_file 100\n");
  write(root / "machine.slice/box/memory.max", "max\n");
  write(root / "machine.slice/box/memory.current", "300\n");
  EXPECT_EQ(available_in_groups("0::/machine.slice/box\n", root.path()), 500U);
  write(root / "machine.slice/box/memory.max", "450\n");
  EXPECT_EQ(available_in_groups("0::/machine.slice/box\n", root.path()), 150U);
  write(root / "machine.slice/box/memory.current", "460\n");  // for a moment
  EXPECT_EQ(available_in_groups("0::/machine.slice/box\n", root.path()), 0U);
  EXPECT_EQ(available_in_groups("0::/another\n", root.path()), std::nullopt);
}

// A container of version 1 sees its own group as the root, but the name that it has outside.
TEST(FreeMemory, OfGroupsOfVersionOne) {
  const TempFolder root;
  write(root / "memory/memory.limit_in_bytes", "8192\n");
  write(root / "memory/memory.usage_in_bytes", "4096\n");
  write(root / "memory/memory.stat", "cache 1\ntotal_inactive_file 1000\n");
  const std::string groups = "5:cpuset:/docker/abc\n4:cpu,memory:/docker/abc\n0::/\n";
  EXPECT_EQ(available_in_groups(groups, root.path()), 5096U);
  EXPECT_EQ(available_in_groups("5:cpuset:/\nnonsense\n", root.path()), std::nullopt);
  EXPECT_EQ(available_in_groups("", root.path()), std::nullopt);
}

// The first limit leaves some room, which the sanitizers' run-time needs always.
TEST(FreeMemory, KeepsToTheLimitOfAddresses) {
  const auto before = available_memory();
  ASSERT_TRUE(before);
  rlimit old{};
  ASSERT_EQ(getrlimit(RLIMIT_AS, &old), 0);
  std::ifstream statm("/proc/self/statm");
  rlim_t pages = 0;
  ASSERT_TRUE(statm >> pages);
  constexpr rlim_t kRoom = rlim_t{256} << 20;
  ASSERT_GT(*before, 2 * kRoom);
  rlimit less = old;
  less.rlim_cur = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + kRoom;
  ASSERT_EQ(setrlimit(RLIMIT_AS, &less), 0);
  const auto left = available_memory();
  std::optional<std::uint64_t> none = 0;
  if (!kSanitized) {
    less.rlim_cur = 1;
    ASSERT_EQ(setrlimit(RLIMIT_AS, &less), 0);
    none = available_memory();
  }
  ASSERT_EQ(setrlimit(RLIMIT_AS, &old), 0);
  EXPECT_EQ(none, 0U);
  ASSERT_TRUE(left);
  EXPECT_LE(*left, kRoom);
  EXPECT_GT(*left, kRoom / 2);  // what reading takes is far less
}

}  // namespace
}  // namespace fluxgs::test
