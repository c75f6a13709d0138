// Which splats are worth storing more exactly.
#include "codec/perceptual_weight.h"

#include <gtest/gtest.h>

#include <cmath>

namespace fluxgs::codec {
namespace {

TEST(PerceptualWeight, AxesHaveNoOrderAndLimits) {
  const glm::vec3 scales[] = {{-1, -3, -2}, {-3, -2, -1}, {-2, -1, -3}, {0, -20, -4}};
  auto extents = extents_of(scales);
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(extents[static_cast<std::size_t>(i)], LogExtents(-1, -2, -3, 0));
  EXPECT_EQ(extents[3], LogExtents(0, -4, -6.5f, 0));
  const float logits[] = {0, 100, -100, 1};
  set_opacities(extents, logits);
  EXPECT_FLOAT_EQ(extents[0].w, std::log(0.5f));
  EXPECT_FLOAT_EQ(extents[1].w, 0);
  EXPECT_FLOAT_EQ(extents[2].w, std::log(0.001f));
}

TEST(PerceptualWeight, StepsArePowersAroundTheirGeometricMean) {
  const LogExtents extents[] = {{0, 0, 0, 0}, {2, 0, 0, 0}, {0, 1, -1, -2}};
  const auto c = step_scale_of({0.5f, 0.25f, -0.25f, 0.1f}, extents);
  // Sums 0, 1, 0.3; their mean is 13/30
  EXPECT_FLOAT_EQ(c[0], std::exp(13 / 30.0f));
  EXPECT_FLOAT_EQ(c[1], std::exp(13 / 30.0f - 1));
  EXPECT_FLOAT_EQ(c[2], std::exp(13 / 30.0f - 0.3f));
}

TEST(PerceptualWeight, StepsHaveLimits) {
  std::vector<LogExtents> extents(100, LogExtents(0));
  extents[0] = LogExtents(100, 100, 100, 0);
  extents[1] = LogExtents(-100, -100, -100, 0);
  const auto c = step_scale_of({1, 0, 0, 0}, extents);
  EXPECT_FLOAT_EQ(c[0], std::exp(-6.0f));
  EXPECT_FLOAT_EQ(c[1], std::exp(2.0f));
  EXPECT_FLOAT_EQ(c[2], 1);
}

}  // namespace
}  // namespace fluxgs::codec
