// Progress of work that has parts.
#include <gtest/gtest.h>

#include <vector>

#include "trainer/core/progress.h"

namespace fluxgs {
namespace {

TEST(ProgressParts, GrowToAllOfThemAndEndThere) {
  std::vector<std::size_t> done;
  const ProgressParts parts(
      [&](std::size_t now, std::size_t total) {
        EXPECT_EQ(total, 1000u);
        done.push_back(now);
      },
      {1, 0, 3, 0});
  for (std::size_t part = 0; part < 4; ++part)
    for (std::size_t i = 1; i <= 7; ++i) parts.part(part)(i, 7);
  EXPECT_TRUE(std::ranges::is_sorted(done));
  EXPECT_EQ(done[6], 250u);
  EXPECT_EQ(std::ranges::count(done, 1000u), 8);  // the end of the third, and the fourth
  EXPECT_EQ(done.back(), 1000u);
}

TEST(ProgressParts, OfPartsAreParts) {
  std::size_t last = 0;
  const ProgressParts outer([&](std::size_t now, std::size_t) { last = now; }, {1, 1});
  const ProgressParts inner(outer.part(1), {1, 1});
  inner.part(0)(1, 1);
  EXPECT_EQ(last, 750u);
  inner.part(1)(1, 1);
  EXPECT_EQ(last, 1000u);
}

TEST(ProgressParts, NobodyNeedsToListen) {
  const ProgressParts parts({}, {1});
  EXPECT_FALSE(parts.part(0));
}

}  // namespace
}  // namespace fluxgs
