// How a cloud is laid out for the GPU; no GL is needed for that.
#include "render/scene_packing.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <vector>

#include <glm/gtc/packing.hpp>

#include "packed.h"
#include "scenes.h"

namespace fluxgs::test {
namespace {

std::vector<glm::vec4> unpacked(const std::vector<std::uint64_t>& halves) {
  std::vector<glm::vec4> values;
  for (const std::uint64_t word : halves) values.push_back(glm::unpackHalf4x16(word));
  return values;
}

TEST(PackScene, StridesHoldWholeGroupsOfFourCoefficients) {
  EXPECT_EQ(render::sh_stride(0), 0U);
  EXPECT_EQ(render::sh_stride(1), 3U);
  EXPECT_EQ(render::sh_stride(2), 6U);
  EXPECT_EQ(render::sh_stride(3), 12U);
}

TEST(PackScene, PutsEveryAttributeInItsPlace) {
  SplatCloud cloud;
  cloud.sh_degree = 1;
  add(cloud, {.position = {1, 2, 3},
              .scale = {0.5F, 0.25F, 2},
              .rotation = {0, 0, 3, 4},
              .opacity = 0.75F,
              .color = {0.25F, 0.5F, 1}});
  cloud.sh_rest = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  const Packed scene = packed(cloud);
  ASSERT_EQ(scene.geometry.size(), 4U);
  EXPECT_EQ(scene.constants.origin, glm::dvec3(1, 2, 3));
  const auto near = [&](std::size_t row, std::array<float, 4> wanted) {
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(scene.geometry[row][i], wanted[i], 1e-6F);
  };
  near(0, {0, 0, 0, std::log2(0.75F)});
  near(1, {0.5F, 0.25F, 2, 0.25F});
  near(2, {0, 0.6F, 0.8F, 0});  // x y z w, of length 1
  near(3, {0.5F, 1, 0, 0});
  const std::vector<glm::vec4> wanted = {{1, 2, 3, 4}, {5, 6, 7, 8}, {9, 0, 0, 0}};
  EXPECT_EQ(unpacked(scene.sh), wanted);
}

TEST(PackScene, EachSplatHasTheCoefficientsOfItsDegree) {
  SplatCloud cloud = mixed_cloud(5, 1);  // of degrees 3, 0, 2, 1, 3
  cloud.positions[2].x = std::nanf("");
  const Packed scene = packed(cloud);
  const auto word = [&](std::size_t i) {
    return std::bit_cast<std::uint32_t>(scene.geometry[4 * i + 3][3]);
  };
  EXPECT_EQ(word(0), 4U * 0 + 3);
  EXPECT_EQ(word(1), 4U * 12 + 0);
  EXPECT_EQ(word(2), 4U * 12 + 2);  // undrawable: its place stays empty
  EXPECT_EQ(word(3), 4U * 18 + 1);
  EXPECT_EQ(word(4), 4U * 21 + 3);
  ASSERT_EQ(scene.sh.size(), 33U);
  EXPECT_EQ(render::sh_bytes(count_degrees(cloud)), 33U * 8);
  const std::vector<glm::vec4> sh = unpacked(scene.sh);
  const auto expect_half = [](float found, float wanted) {
    EXPECT_NEAR(found, wanted, std::fabs(wanted) * 0x1p-11F) << "to the nearest half";
  };
  expect_half(sh[18][1], cloud.sh_rest[45].y);
  expect_half(sh[20][0], cloud.sh_rest[47].z);
  EXPECT_EQ(sh[20][1], 0.0F);
  expect_half(sh[32][0], cloud.sh_rest[74].z);
}

TEST(PackScene, CoefficientsBeyondHalfFloatsAreTheLargestOfThem) {
  SplatCloud cloud;
  cloud.sh_degree = 1;
  add(cloud, {});
  cloud.sh_rest = {{1e6F, -1e14F, 65504}, {65519, 1e-9F, 0}, {0, 0, 0}};
  const std::vector<glm::vec4> sh = unpacked(packed(cloud).sh);
  EXPECT_EQ(sh[0], glm::vec4(65504, -65504, 65504, 65504));
  EXPECT_NEAR(sh[1][0], 0, 1e-7);
}

TEST(PackScene, OriginIgnoresStraysAndKeepsBits) {
  SplatCloud cloud;
  for (const float x : {1e5F, 1e5F + 1, 1e5F + 2, 1e30F, std::nanf("")})
    add(cloud, {.position = {x, 0, 0}});
  const Packed scene = packed(cloud);
  EXPECT_EQ(scene.constants.origin.x, 1e5 + 1);
  EXPECT_EQ(scene.geometry[0][0], -1.0F);
  EXPECT_EQ(scene.geometry[8][0], 1.0F);
  EXPECT_EQ(scene.undrawable, 2U);
  EXPECT_EQ(scene.geometry[12][3], -1e30F);
  EXPECT_EQ(scene.geometry[16][3], -1e30F);
  EXPECT_EQ(scene.constants.lowest.x, -1.0);  // The box holds those that are drawn
  EXPECT_EQ(scene.constants.highest.x, 1.0);
}

TEST(PackScene, PartsMakeTheWhole) {
  SplatCloud cloud = mixed_cloud(100, 2);
  cloud.positions[41].x = std::nanf("");
  const std::vector<std::uint32_t> some = {3, 4, 17, 40, 41, 42, 60, 61, 62, 63, 98};
  const Packed whole = packed(in_order(cloud, some));
  const render::RenderCloud kept = cloud;
  render::ScenePacker packer(kept, some);
  EXPECT_EQ(packer.constants().count, some.size());
  EXPECT_EQ(packer.constants().origin, whole.constants.origin);
  EXPECT_EQ(packer.constants().lowest, whole.constants.lowest);
  EXPECT_EQ(packer.constants().highest, whole.constants.highest);
  EXPECT_EQ(packer.degrees(), count_degrees(in_order(cloud, some)));
  EXPECT_EQ(packer.undrawable(), 1U);
  render::PackedSplats part, all;
  std::vector<glm::vec3> positions;
  for (const std::size_t wanted : {4U, 4U, 3U, 0U}) {
    packer.next(4, part);
    EXPECT_EQ(part.geometry.size(), 4 * wanted);
    all.geometry.insert(all.geometry.end(), part.geometry.begin(), part.geometry.end());
    all.sh.insert(all.sh.end(), part.sh.begin(), part.sh.end());
    render::add_positions(part, positions);
  }
  const auto bits = [](const std::vector<std::array<float, 4>>& values) {  // some are no numbers
    std::vector<std::uint32_t> words(4 * values.size());
    std::memcpy(words.data(), values.data(), sizeof(words[0]) * words.size());
    return words;
  };
  EXPECT_EQ(bits(all.geometry), bits(whole.geometry));
  EXPECT_EQ(all.sh, whole.sh);
  ASSERT_EQ(positions.size(), some.size());
  EXPECT_TRUE(std::isnan(positions[4].x));
  EXPECT_EQ(positions[5].y, whole.geometry[20][1]);
}

TEST(PackScene, ALowerDegreeLeavesOutWhatIsBeyond) {
  const SplatCloud cloud = mixed_cloud(300, 2);
  const render::RenderCloud kept = cloud;
  for (const int degree : {2, 1, 0}) {
    SplatCloud low = cloud;
    limit_sh_degree(low, degree);
    const Packed expected = packed(low);
    render::ScenePacker packer(kept, {}, degree);
    render::PackedSplats part;
    packer.next(cloud.size(), part);
    EXPECT_EQ(part.geometry, expected.geometry) << degree;
    EXPECT_EQ(part.sh, expected.sh) << degree;
    EXPECT_EQ(packer.degrees(), render::limited(count_degrees(cloud), degree));
    EXPECT_EQ(packer.constants().sh_degree, degree);
  }
}

TEST(PackScene, AnEmptyCloudIsEmpty) {
  const Packed scene = packed({});
  EXPECT_TRUE(scene.geometry.empty());
  EXPECT_TRUE(scene.sh.empty());
}

}  // namespace
}  // namespace fluxgs::test
