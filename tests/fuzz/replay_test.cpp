// The fuzz targets as ordinary tests: every input that was ever a finding, every seed, and a few
// thousand damaged seeds. A promise that is broken ends the program; its input is the last one
// named.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <random>

#include "fluxgs/io/file.h"
#include "seeds.h"
#include "support/sanitized.h"

namespace fluxgs::fuzz {
namespace {

namespace fs = std::filesystem;

std::vector<Target> sorted_targets() {
  std::vector<Target> all = targets();
  std::ranges::sort(all, {}, [](const Target& t) { return std::string_view(t.name); });
  return all;
}

class Replay : public testing::TestWithParam<Target> {
 protected:
  // Named before it runs, for it may be the last that does.
  static void run(const std::string& name, const Bytes& input) {
    std::fprintf(stderr, "%s (%zu bytes)\n", name.c_str(), input.size());
    GetParam().run(Bytes(input));  // a block of exactly its size
  }

  static const Seeds& seeds() {
    static const Seeds all = make_seeds();
    return all;
  }
};

TEST_P(Replay, Corpus) {
  const fs::path folder = fs::path(FLUXGS_FUZZ_CORPUS) / GetParam().name;
  if (!fs::exists(folder)) GTEST_SKIP() << "nothing was found yet";
  for (const auto& entry : fs::directory_iterator(folder)) {
    const auto bytes = read_file(entry.path());
    ASSERT_TRUE(bytes) << bytes.error().message();
    run(entry.path().filename().string(), *bytes);
  }
}

TEST_P(Replay, Seeds) {
  const auto found = seeds().find(GetParam().name);
  ASSERT_NE(found, seeds().end()) << "a target needs seeds";
  for (const auto& [name, bytes] : found->second) run(name, bytes);
}

// What libFuzzer does, in small, where there is no clang to build it.
TEST_P(Replay, DamagedSeeds) {
  constexpr std::size_t kEach = test::kSanitized ? 4 : 10, kLargest = 20000;
  std::mt19937 random(7);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  for (const auto& [name, seed] : seeds().at(GetParam().name)) {
    if (seed.empty() || seed.size() > kLargest) continue;
    for (std::size_t round = 0; round < kEach; ++round) {
      Bytes bytes = seed;
      for (std::size_t n = 1 + below(4); n > 0; --n) {
        bytes[below(bytes.size())] = static_cast<std::byte>(below(256));
      }
      if (below(4) == 0) bytes.resize(below(bytes.size()));
      SCOPED_TRACE(name);
      GetParam().run(Bytes(bytes));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Replay, testing::ValuesIn(sorted_targets()),
                         [](const auto& name_of) { return std::string(name_of.param.name); });

TEST(ReplayFolders, AllBelongToATarget) {
  for (const auto& entry : fs::directory_iterator(FLUXGS_FUZZ_CORPUS)) {
    if (!entry.is_directory()) continue;
    EXPECT_TRUE(std::ranges::any_of(targets(), [&](const Target& target) {
      return entry.path().filename() == target.name;
    })) << entry.path().string();
  }
}

}  // namespace
}  // namespace fluxgs::fuzz
