// Positions on a grid, in the order of its cells.
#include "codec/positions.h"
#include "fluxgs/byte_reader.h"
#include "fluxgs/morton.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include <glm/geometric.hpp>

#include "support/draco_cells.h"

namespace fluxgs::codec {
namespace {

std::vector<glm::vec3> random_positions(std::size_t count, const glm::vec3& center = {}) {
  std::mt19937 random(4);
  std::normal_distribution<float> normal;
  std::vector<glm::vec3> positions(count);
  for (glm::vec3& p : positions)
    p = center + glm::vec3(normal(random), normal(random), 0.1f * normal(random));
  return positions;
}

std::vector<glm::vec3> sorted(const std::vector<glm::vec3>& positions) {
  std::vector<glm::vec3> result;
  for (const std::uint32_t i : morton_order(positions)) result.push_back(positions[i]);
  return result;
}

TEST(Morton, IsAPermutationThatKeepsNeighboursTogether) {
  const auto positions = random_positions(5000);
  auto order = morton_order(positions);
  const auto length = [](const std::vector<glm::vec3>& path) {
    double total = 0;
    for (std::size_t i = 1; i < path.size(); ++i)
      total += double{glm::distance(path[i - 1], path[i])};
    return total;
  };
  EXPECT_LT(length(sorted(positions)), 0.15 * length(positions));
  std::ranges::sort(order);
  for (std::uint32_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], i);
  EXPECT_EQ(morton_order(std::vector<glm::vec3>(3, glm::vec3(1))),
            (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(morton_order({{0, 0, 0}, {1, 1, 1}, {0, 0, 1}, {1, 0, 0}}),
            (std::vector<std::uint32_t>{0, 3, 2, 1}));
}

TEST(Morton, CellsGoByTheirHighestBits) {
  using Order = std::vector<std::uint32_t>;
  const std::vector<glm::ivec3> corners{{0, 0, 0}, {1, 1, 1}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(morton_order(corners), (Order{0, 3, 4, 2, 1}));
  const std::vector<glm::ivec3> far{{1 << 23, 0, 0}, {0, 4095, 4095}, {0, 4096, 0}, {4095, 0, 0}};
  EXPECT_EQ(morton_order(far), (Order{3, 1, 2, 0}));
  EXPECT_EQ(morton_order(std::vector<glm::ivec3>(3, glm::ivec3(7))), (Order{0, 1, 2}));
  EXPECT_EQ(morton_order(std::vector<glm::ivec3>()), Order());
}

std::vector<glm::vec3> in_file_order(const std::vector<glm::vec3>& positions, double step) {
  std::vector<glm::vec3> result;
  for (const std::uint32_t i : position_order(positions, step)) result.push_back(positions[i]);
  return result;
}

TEST(Positions, EachIsWithinHalfAStepAndInItsPlace) {
  for (const glm::vec3& center : {glm::vec3(0), glm::vec3(1e5f, -3e4f, 2)}) {
    for (const double step : {0.1, 1e-3}) {
      auto positions = random_positions(3000, center);
      positions[7] = positions[8];  // equal ones stay two
      positions = in_file_order(positions, step);
      Bytes bytes;
      ASSERT_TRUE(encode_positions(positions, step, bytes));
      std::vector<glm::vec3> back(positions.size());
      ByteReader in(bytes);
      const auto done = decode_positions(in, CellCoding::octree, back);
      ASSERT_TRUE(done) << done.error().message();
      EXPECT_EQ(in.left(), 0u);
      const double float_error = center.x != 0 ? 0.005 : 1e-6;  // of a float at that distance
      for (std::size_t i = 0; i < back.size(); ++i)
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(back[i][c], positions[i][c], 0.5 * step + float_error);
    }
  }
}

TEST(Positions, ThoseOfVersion2AreRead) {
  const std::vector<Cell> cells{{5, 0, 7}, {0, 1, 2}, {0, 1, 2}};
  const Bytes bytes = test::draco_positions(cells, 0.5);
  std::vector<glm::vec3> back(3);
  ByteReader in(bytes);
  const auto done = decode_positions(in, CellCoding::draco, back);
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_EQ(back, (std::vector<glm::vec3>{{2.5f, 0, 3.5f}, {0, 0.5f, 1}, {0, 0.5f, 1}}));
  ByteReader again(bytes);
  EXPECT_FALSE(decode_positions(again, CellCoding::octree, back));
}

TEST(Positions, TooFineAGridIsAnError) {
  Bytes bytes;
  const std::vector<glm::vec3> wide{{0, 0, 0}, {1e6f, 0, 0}};
  const auto done = encode_positions(wide, 1e-6, bytes);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().what.find("steps"), std::string::npos);
  EXPECT_EQ(position_order(wide, 1e-6), (std::vector<std::uint32_t>{0, 1}));
  const auto reaches = [&](float x) {
    return encode_positions(std::vector<glm::vec3>{{0, 0, 0}, {x, 0, 0}}, 1, bytes).has_value();
  };
  EXPECT_TRUE(reaches(0x1p24f - 1));
  EXPECT_FALSE(reaches(0x1p24f));
}

TEST(Positions, ThatAreNotFiniteAreRefused) {
  Bytes bytes;
  ASSERT_TRUE(encode_positions(std::vector<glm::vec3>{{0, 0, 0}, {3, 0, 0}}, 1, bytes));
  const double far = 1e39;  // as a step
  std::memcpy(bytes.data() + 3 * sizeof(double), &far, sizeof far);
  std::vector<glm::vec3> back(2);
  ByteReader in(bytes);
  const auto done = decode_positions(in, CellCoding::octree, back);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().message(), "positions: splat 1 is not finite");
}

}  // namespace
}  // namespace fluxgs::codec
