// Scenes as they are kept for drawing: half floats, and an order in space.
#include "render/render_cloud.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>
#include <glm/gtc/packing.hpp>

#include "fluxgs/morton.h"
#include "image_fixture.h"
#include "render/splat_budget.h"
#include "scenes.h"

namespace fluxgs::test {
namespace {

using render::RenderCloud;

SplatCloud shuffled(const SplatCloud& cloud) {
  std::vector<std::uint32_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::shuffle(order, std::mt19937(3));
  return in_order(cloud, order);
}

void expect_same(const RenderCloud& a, const RenderCloud& b) {
  EXPECT_EQ(a.sh_degree, b.sh_degree);
  EXPECT_TRUE(a.base.positions == b.base.positions && a.base.log_scales == b.base.log_scales &&
              a.base.rotations == b.base.rotations &&
              a.base.opacity_logits == b.base.opacity_logits && a.base.sh_dc == b.base.sh_dc &&
              a.sh == b.sh);
}

TEST(RenderCloud, HasHalfFloats) {
  SplatCloud cloud = mixed_cloud(200, 3);
  cloud.filter = {.dilation = 0.1, .compensated = true};
  cloud.sh_rest[5] = {1e6F, -1e6F, 1e20F};
  const RenderCloud kept = cloud;
  EXPECT_EQ(kept.size(), cloud.size());
  EXPECT_EQ(kept.sh_degree, cloud.sh_degree);
  EXPECT_EQ(kept.base.sh_degree, 0);
  EXPECT_EQ(kept.base.filter, cloud.filter);
  EXPECT_EQ(kept.file_splats, cloud.size());
  ASSERT_EQ(kept.sh.size(), 3 * cloud.sh_rest.size());
  for (std::size_t i = 0; i < kept.sh.size(); ++i)
    if (i / 3 != 5) {
      EXPECT_EQ(kept.sh[i], glm::packHalf1x16(cloud.sh_rest[i / 3][static_cast<int>(i % 3)])) << i;
    }
  EXPECT_EQ(glm::unpackHalf1x16(kept.sh[15]), 65504.0F);
  EXPECT_EQ(glm::unpackHalf1x16(kept.sh[16]), -65504.0F);
  EXPECT_EQ(glm::unpackHalf1x16(kept.sh[17]), INFINITY) << "such a splat is not drawn";
  EXPECT_EQ(count_degrees(kept), count_degrees(cloud));
  expect_same(RenderCloud(splat_cloud_of(kept)), kept);
}

TEST(RenderCloud, IsFilledSplatBySplat) {
  const SplatCloud cloud = mixed_cloud(200, 2);
  const RenderCloud whole = cloud;
  RenderCloud filled;
  filled.sh_degree = 3;
  reserve(filled, cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) append(cloud, i, filled);
  expect_same(filled, whole);
  // Of a lower degree: the bands that it does not have are zeros
  SplatCloud low = cloud, padded = cloud;
  limit_sh_degree(low, 1);
  for (std::size_t i = 0; i < padded.sh_rest.size(); ++i)
    if (i % 15 >= 3) padded.sh_rest[i] = glm::vec3(0);
  RenderCloud from_low;
  from_low.sh_degree = 3;
  for (std::size_t i = 0; i < low.size(); ++i) append(low, i, from_low);
  expect_same(from_low, RenderCloud(padded));
}

TEST(DrawOrder, IsThatOfTheCurve) {
  for (const int degree : {0, 3}) {
    const SplatCloud cloud = shuffled(random_cloud(20'000, degree, 5));
    RenderCloud kept = cloud;
    EXPECT_FALSE(render::lies_in_order(kept.base));
    put_in_order(kept);
    EXPECT_TRUE(render::lies_in_order(kept.base));
    expect_same(kept, RenderCloud(in_order(cloud, morton_order(cloud.positions))));
  }
}

// That of another axis, or with a few splats elsewhere, will do as well.
TEST(DrawOrder, StaysWhereNeighboursLieTogether) {
  SplatCloud cloud = random_cloud(20'000, 1, 5);
  cloud = in_order(cloud, morton_order(cloud.positions));
  for (glm::vec3& p : cloud.positions) p = {-p.z, p.x, -p.y};
  for (std::size_t i = 0; i < 1000; ++i) std::swap(cloud.positions[i], cloud.positions[19'999 - i]);
  const RenderCloud before = cloud;
  RenderCloud kept = before;
  put_in_order(kept);
  expect_same(kept, before);
}

TEST(DrawOrder, OfFewSplatsOrInOnePlaceIsNoTrouble) {
  for (const std::size_t count : {0U, 1U, 2U, 999U, 5000U}) {
    SplatCloud cloud = random_cloud(count, 1, 5);
    if (count == 5000U) cloud.positions.assign(count, glm::vec3(1));
    RenderCloud kept = cloud;
    put_in_order(kept);
    expect_same(kept, RenderCloud(cloud));
  }
}

class DrawOrderTest : public ImageTest {};

// Splats at the same depth may change places, no more.
TEST_P(DrawOrderTest, DoesNotChangeThePicture) {
  const SplatCloud cloud = shuffled(random_cloud(3000, 2, 5));
  const Camera camera = orbit_camera(120, 90, {}, 2, 1, 4);
  const ReferenceImage reference = render_reference(cloud, camera, kRose);
  RenderCloud ordered = cloud;
  put_in_order(ordered);
  must(renderer().upload(cloud));
  expect_like("as it came", reference, camera, kRose, TargetFormat::rgba8);
  must(renderer().upload(ordered));
  expect_like("in order", reference, camera, kRose, TargetFormat::rgba8);
}

FLUXGS_GL_TEST_SUITE(DrawOrderTest);

}  // namespace
}  // namespace fluxgs::test
