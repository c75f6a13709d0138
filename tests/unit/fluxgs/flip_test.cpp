// FLIP errors of rendered views, where FLIP is installed.
#include <gtest/gtest.h>

#include <cstdint>

#include "tools/fluxgs/commands/flip.h"

namespace fluxgs::cli {
namespace {

TEST(Flip, OfTheSameImageIsNothing) {
  if (const auto there = check_flip(); !there) GTEST_SKIP() << there.error().message();
  View view;
  view.rgb = Image<std::uint8_t>(24, 16, 3);
  for (int x = 0; x < 24; ++x) view.rgb.at(x, 5)[0] = static_cast<std::uint8_t>(10 * x);
  const auto show = [&](float more) {
    return [&view, more](const Camera&) -> Expected<PlanarImage> {
      PlanarImage image(24, 16, 3);
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < 16; ++y)
          for (int x = 0; x < 24; ++x)
            image.row(c, y)[x] = static_cast<float>(view.rgb.at(x, y)[c]) / 255 + more;
      return image;
    };
  };
  const auto same = flip_errors({view}, show(0)), other = flip_errors({view}, show(0.3f));
  ASSERT_TRUE(same && other);
  EXPECT_DOUBLE_EQ(same->at(0), 0);
  EXPECT_GT(other->at(0), 0.1);
}

}  // namespace
}  // namespace fluxgs::cli
