// Point clouds in .ply files of any program.
#include "fluxgs/io/ply_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <string>

namespace fluxgs {
namespace {

Expected<PlyPoints> read(const std::string& text) {
  return read_ply_points(std::as_bytes(std::span(text)), "points.ply");
}

template <class T>
std::string big_endian(T value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return {bytes.rbegin(), bytes.rend()};
}

TEST(PlyPoints, TextWithColoursAndOtherProperties) {
  const auto points = read(
      "ply\nformat ascii 1.0\ncomment of nobody\nelement vertex 2\nproperty uchar green\n"
      "property double z\nproperty float nx\nproperty double x\nproperty double y\n"
      "property uchar red\nproperty uchar blue\nend_header\n"
      "2 0.3 9 0.1 0.2 1 3\n255 nan 9 -1e300 5 0 128\n");
  ASSERT_TRUE(points) << points.error().message();
  EXPECT_EQ(points->positions[0], glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_EQ(points->colors[0], glm::u8vec3(1, 2, 3));
  EXPECT_EQ(points->positions[1].x, -1e300);
  EXPECT_TRUE(std::isnan(points->positions[1].z));
  EXPECT_EQ(points->colors[1], glm::u8vec3(0, 255, 128));
}

TEST(PlyPoints, BigEndianBehindOtherElements) {
  const auto points = read(
      "ply\nformat binary_big_endian 1.0\nelement camera 1\nproperty list uchar short sizes\n"
      "element vertex 1\nproperty float x\nproperty short y\nproperty double z\nend_header\n" +
      std::string("\x02\x00\x01\x00\x02", 5) + big_endian(1.5f) + big_endian(std::int16_t{-300}) +
      big_endian(0.1));
  ASSERT_TRUE(points) << points.error().message();
  EXPECT_EQ(points->positions[0], glm::dvec3(1.5, -300, 0.1));
  EXPECT_EQ(points->colors[0], glm::u8vec3(255));  // white without all three colours
}

TEST(PlyPoints, ErrorsNameThePlace) {
  const auto error = [](const std::string& text) {
    const auto points = read(text);
    return points ? std::string() : points.error().message();
  };
  const std::string head = "ply\nformat ascii 1.0\n";
  EXPECT_THAT(error(head + "element face 0\nend_header\n"), testing::HasSubstr("\"vertex\""));
  EXPECT_THAT(error(head + "element vertex 0\nproperty float x\nproperty float y\nend_header\n"),
              testing::HasSubstr("z"));
  const std::string xyz = "property float x\nproperty float y\nproperty float z\nend_header\n";
  EXPECT_THAT(error(head + "element vertex 2\n" + xyz + "1 2 3\n4 five 6\n"),
              testing::HasSubstr("row 1"));
  EXPECT_THAT(error(head + "element vertex -1\n" + xyz), testing::HasSubstr("header line 3"));
  EXPECT_THAT(error(head + "element vertex 9000000000\n" + xyz), testing::HasSubstr("promises"));
}

}  // namespace
}  // namespace fluxgs
