// Cells as an octree, and as Draco kept them before.
#include "codec/octree.h"

#include <gtest/gtest.h>

#include <random>

#include <glm/geometric.hpp>

#include "codec/draco_positions.h"
#include "codec/rans.h"
#include "fluxgs/morton.h"
#include "support/draco_cells.h"

namespace fluxgs::codec {
namespace {

using Cells = std::vector<Cell>;

Cells sorted(const Cells& cells) {
  Cells result;
  for (const std::uint32_t i : morton_order(cells)) result.push_back(cells[i]);
  return result;
}

/// Near a sphere.
Cells some_cells(std::size_t count, double radius) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Cells cells;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3 from(normal(random), normal(random), normal(random));
    cells.emplace_back(radius * (1.1 + glm::normalize(from)) + 0.01 * radius * normal(random));
  }
  return sorted(cells);
}

Bytes encoded(const Cells& cells) {
  Bytes bytes;
  encode_octree(cells, bytes);
  return bytes;
}

/// All of the bytes decode to the cells.
template <class Decode>
void expect_decodes(const Bytes& bytes, const Cells& cells, const Decode& decode) {
  Cells back(cells.size(), Cell(-1));
  ByteReader in(bytes);
  const auto done = decode(in, back);
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_EQ(in.left(), 0u);
  EXPECT_EQ(back, cells);
}

TEST(Octree, CellsComeBack) {
  constexpr int kLast = (1 << kOctreeLevels) - 1;
  const Cells lists[] = {{Cell(0)},
                         {Cell(kLast)},
                         Cells(70'000, Cell(0)),
                         Cells(70'000, Cell(5, 0, kLast)),
                         sorted({{0, 0, 1}, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}}),
                         sorted({Cell(kLast), Cell(0), {kLast, 0, 0}, {0, kLast - 1, 3}}),
                         some_cells(5000, 40),
                         some_cells(5000, 7e6)};
  for (const Cells& cells : lists) expect_decodes(encoded(cells), cells, decode_octree);
}

TEST(Octree, TakesTwoBitsACellLessThanDraco) {
  const Cells cells = some_cells(50'000, 500);
  const double octree = 8.0 * static_cast<double>(encoded(cells).size()) / 50'000;
  const double draco = 8.0 * static_cast<double>(test::draco_cells(cells).size()) / 50'000;
  std::printf("bits a cell: octree %.2f, Draco %.2f\n", octree, draco);
  EXPECT_LT(octree, draco - 2);
}

TEST(Octree, DamageIsNamed) {
  const auto error_of = [](const Bytes& bytes, std::size_t count) {
    Cells cells(count);
    ByteReader in(bytes);
    const auto done = decode_octree(in, cells);
    return done ? "" : done.error().message();
  };
  const auto stream = [](int levels, const std::vector<std::vector<std::int32_t>>& channels) {
    Bytes bytes{static_cast<std::byte>(levels)};
    encode_values(channels, bytes);
    return bytes;
  };
  EXPECT_EQ(error_of(stream(1, {{3}, {0, 0}}), 2), "");
  EXPECT_EQ(error_of({}, 2), "positions: are cut off");
  EXPECT_EQ(error_of(stream(25, {{3}, {0, 0}}), 2),
            "positions: have 25 levels, expected 24 at most");
  for (const int children : {0, -1, 256, 1 << 20})
    EXPECT_EQ(error_of(stream(1, {{children}, {0, 0}}), 2),
              "positions: are damaged: a node without children, or too many cells");
  EXPECT_EQ(error_of(stream(1, {{7}, {0, 0, 0}}), 2),
            "positions: are damaged: a node without children, or too many cells");
  for (const std::vector<std::int32_t>& repeats :
       {std::vector{0, 0}, {0, 2}, {-1, 2}, {1, 1}, {1 << 29, 1 << 29}})
    EXPECT_EQ(error_of(stream(1, {{3}, repeats}), 3),
              "positions: hold another number of splats, expected 3");
}

/// Each cut is an error; damage is one, or gives other cells, and does not crash.
template <class Decode>
void expect_survives(const Bytes& good, std::size_t count, const Decode& decode) {
  Cells cells(count);
  for (std::size_t size = 0; size < good.size(); ++size) {
    ByteReader in(std::span<const std::byte>(good).first(size));
    EXPECT_FALSE(decode(in, cells)) << size;
  }
  std::mt19937 random(2);
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes = good;
    bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
    ByteReader in(bytes);
    (void)decode(in, cells);
  }
}

TEST(Octree, SurvivesCutsAndDamage) {
  expect_survives(encoded(some_cells(300, 100)), 300, decode_octree);
}

TEST(DracoCells, AreStillRead) {
  const Cells cells = some_cells(3000, 1e4);
  expect_decodes(test::draco_cells(cells), cells, decode_draco);
}

TEST(DracoCells, SurviveCutsLyingCountsAndDamage) {
  const Bytes good = test::draco_cells(some_cells(100, 100));
  expect_survives(good, 100, decode_draco);
  Cells more(101);
  ByteReader in(good);
  const auto lied = decode_draco(in, more);
  ASSERT_FALSE(lied);
  EXPECT_NE(lied.error().what.find("100 points"), std::string::npos) << lied.error().what;
}

}  // namespace
}  // namespace fluxgs::codec
