// Positions through Draco, in the order given.
#include "codec/positions.h"
#include "fluxgs/byte_reader.h"
#include "fluxgs/morton.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include <glm/geometric.hpp>

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

TEST(Positions, EachIsWithinHalfAStepAndInItsPlace) {
  for (const glm::vec3& center : {glm::vec3(0), glm::vec3(1e5f, -3e4f, 2)}) {
    for (const double step : {0.1, 1e-3}) {
      auto positions = random_positions(3000, center);
      positions[7] = positions[8];  // equal ones stay two
      Bytes bytes;
      ASSERT_TRUE(encode_positions(positions, step, bytes));
      std::vector<glm::vec3> back(positions.size());
      ByteReader in(bytes);
      const auto done = decode_positions(in, back);
      ASSERT_TRUE(done) << done.error().message();
      EXPECT_EQ(in.left(), 0u);
      const double float_error = center.x != 0 ? 0.005 : 1e-6;  // of a float at that distance
      for (std::size_t i = 0; i < back.size(); ++i)
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(back[i][c], positions[i][c], 0.5 * step + float_error);
    }
  }
}

TEST(Positions, MortonOrderPaysOff) {
  const auto positions = random_positions(20'000);
  Bytes as_is, in_order;
  ASSERT_TRUE(encode_positions(positions, 2e-3, as_is));
  ASSERT_TRUE(encode_positions(sorted(positions), 2e-3, in_order));
  EXPECT_LT(static_cast<double>(in_order.size()), 0.75 * static_cast<double>(as_is.size()));
}

TEST(Positions, TooFineAGridIsAnError) {
  Bytes bytes;
  const auto done = encode_positions({{0, 0, 0}, {1e6f, 0, 0}}, 1e-6, bytes);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().what.find("steps"), std::string::npos);
  EXPECT_TRUE(encode_positions({{0, 0, 0}, {0x1p24f - 1, 0, 0}}, 1, bytes));
  EXPECT_FALSE(encode_positions({{0, 0, 0}, {0x1p24f, 0, 0}}, 1, bytes));
}

TEST(Positions, CutsLyingCountsAndDamage) {
  const auto positions = random_positions(100);
  Bytes good;
  ASSERT_TRUE(encode_positions(positions, 0.01, good));
  std::vector<glm::vec3> back(positions.size());
  for (std::size_t size = 0; size < good.size(); ++size) {
    ByteReader in(std::span<const std::byte>(good).first(size));
    EXPECT_FALSE(decode_positions(in, back)) << size;
  }
  std::vector<glm::vec3> more(positions.size() + 1);
  ByteReader in(good);
  const auto lied = decode_positions(in, more);
  ASSERT_FALSE(lied);
  EXPECT_NE(lied.error().what.find("100 points"), std::string::npos) << lied.error().what;
  std::mt19937 random(2);
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes = good;
    bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
    ByteReader damaged(bytes);
    (void)decode_positions(damaged, back);  // an error or other positions, but no crash
  }
}

}  // namespace
}  // namespace fluxgs::codec
