#include <algorithm>
#include <cmath>
#include <limits>

#include "compressed_ply_support.h"
#include "shared-format/src/io/splat/spatial_order.h"

namespace fluxgs {
namespace {

using namespace test;

// The cloud in the order of the writer.
SplatCloud ordered(const SplatCloud& cloud) {
  return in_order(cloud, io::spatial_order(cloud.positions));
}

double opacity(float logit) { return 1 / (1 + std::exp(-double{logit})); }

TEST(CompressedPlyWriter, ErrsByHalfALevelOfEachChunk) {
  for (const int degree : {0, 1, 2, 3}) {
    for (const std::size_t count : {std::size_t(1), std::size_t(256), std::size_t(1000)}) {
      SplatCloud cloud = random_cloud(count, degree, 3, 20);
      FLUXGS_UNWRAP(bytes, encode_compressed_ply(cloud, "x"));
      FLUXGS_UNWRAP(scene, read_compressed_ply(bytes, "x"));
      cloud = ordered(cloud);
      ASSERT_EQ(scene.cloud.size(), count);
      EXPECT_EQ(scene.cloud.sh_degree, degree);
      for (std::size_t begin = 0; begin < count; begin += 256) {
        const std::size_t end = std::min(count, begin + 256);
        glm::vec3 low(1e9F), high(-1e9F), low_scale(1e9F), high_scale(-1e9F);
        for (std::size_t i = begin; i < end; ++i) {
          low = glm::min(low, cloud.positions[i]);
          high = glm::max(high, cloud.positions[i]);
          low_scale = glm::min(low_scale, cloud.log_scales[i]);
          high_scale = glm::max(high_scale, cloud.log_scales[i]);
        }
        for (std::size_t i = begin; i < end; ++i) {
          for (int c = 0; c < 3; ++c) {
            const double most = c == 1 ? 1023 : 2047;
            const auto expect_near = [&](const glm::vec3& a, const glm::vec3& b,
                                         const glm::vec3& range) {
              ASSERT_LE(std::abs(double{a[c]} - double{b[c]}), 0.5 * range[c] / most + 1e-5);
            };
            expect_near(scene.cloud.positions[i], cloud.positions[i], high - low);
            expect_near(scene.cloud.log_scales[i], cloud.log_scales[i], high_scale - low_scale);
          }
          ASSERT_LE(
              std::abs(opacity(scene.cloud.opacity_logits[i]) - opacity(cloud.opacity_logits[i])),
              0.5 / 255 + 1e-6);
          const glm::quat a = glm::normalize(scene.cloud.rotations[i]),
                          b = glm::normalize(cloud.rotations[i]);
          ASSERT_GT(std::abs(glm::dot(a, b)), 1 - 5e-6);
        }
      }
      for (std::size_t k = 0; k < cloud.sh_rest.size(); ++k)
        for (int c = 0; c < 3; ++c) {
          const float limited = std::clamp(cloud.sh_rest[k][c], -4.0F, 4.0F);
          ASSERT_LE(std::abs(scene.cloud.sh_rest[k][c] - limited), 1 / 32.0F);
        }
    }
  }
}

// One splat far from all others leaves their chunks small.
TEST(CompressedPlyWriter, FarSplatsCoarsenOnlyTheirChunk) {
  SplatCloud cloud = random_cloud(5000, 0, 3, 5);
  cloud.positions[17] = {3e6F, -2e6F, 1e5F};
  FLUXGS_UNWRAP(bytes, encode_compressed_ply(cloud, "x"));
  FLUXGS_UNWRAP(scene, read_compressed_ply(bytes, "x"));
  cloud = ordered(cloud);
  std::size_t coarse = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    coarse += glm::distance(scene.cloud.positions[i], cloud.positions[i]) > 0.01F;
  EXPECT_LE(coarse, 256U);
}

TEST(CompressedPlyWriter, FlatSplatsDoNotCoarsenScales) {
  SplatCloud cloud = random_cloud(100, 0);
  cloud.log_scales[5].z = -87;
  FLUXGS_UNWRAP(bytes, encode_compressed_ply(cloud, "x"));
  FLUXGS_UNWRAP(scene, read_compressed_ply(bytes, "x"));
  cloud = ordered(cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    EXPECT_NEAR(scene.cloud.log_scales[i].z, std::max(cloud.log_scales[i].z, -20.0F), 0.012F);
}

TEST(CompressedPlyWriter, EdgesOfTheRange) {
  SplatCloud none;
  none.sh_degree = 2;
  FLUXGS_UNWRAP(empty, encode_compressed_ply(none, "x"));
  FLUXGS_UNWRAP(nothing, read_compressed_ply(empty, "x"));
  EXPECT_EQ(nothing.cloud.size(), 0U);
  SplatCloud cloud = random_cloud(3, 1);
  cloud.rotations = {glm::quat(0, 0, 0, 0), glm::quat(-2, 0, 0, 0), glm::quat(1e-30F, 0, 0, 0)};
  cloud.opacity_logits = {100, -100, 0};
  cloud.sh_rest[0] = glm::vec3(1e9F, -1e9F, 0);
  FLUXGS_UNWRAP(bytes, encode_compressed_ply(cloud, "x"));
  FLUXGS_UNWRAP(scene, read_compressed_ply(bytes, "x"));
  for (const glm::quat& q : scene.cloud.rotations) EXPECT_NEAR(std::abs(q.w), 1, 1e-6);
  cloud.positions[1].x = std::numeric_limits<float>::quiet_NaN();
  FLUXGS_UNWRAP(fewer, encode_compressed_ply(cloud, "x"));
  FLUXGS_UNWRAP(two, read_compressed_ply(fewer, "x"));
  EXPECT_EQ(two.cloud.size(), 2U);
  cloud.rotations.pop_back();
  expect_error(encode_compressed_ply(cloud, "x.ply"), {"x.ply", "arrays disagree"});
}

}  // namespace
}  // namespace fluxgs
