#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "shared-format/src/io/sog/scalar_codebook.h"
#include "shared-format/src/io/sog/sh_palette.h"
#include "shared-format/src/io/splat/spatial_order.h"
#include "sog_support.h"

namespace fluxgs {
namespace {

using namespace test;

double opacity(float logit) { return 1 / (1 + std::exp(-double{logit})); }

float squared_error(std::span<const float> numbers, const io::ScalarCodebook& codebook) {
  float sum = 0;
  for (const float v : numbers) {
    const float off = codebook[io::nearest_index(codebook, v)] - v;
    sum += off * off;
  }
  return sum;
}

io::ScalarCodebook codebook_of(std::span<const float> numbers) {
  std::vector<io::WeightedNumber> weighted;
  for (const float v : numbers) weighted.push_back({v, 1});
  return io::make_scalar_codebook(std::move(weighted));
}

TEST(ScalarCodebook, FewNumbersAreKept) {
  const std::vector<float> few{3, -1, 3, 7, -1};
  EXPECT_EQ(squared_error(few, codebook_of(few)), 0);
  std::vector<float> levels;
  for (int i = 0; i < 256; ++i) levels.push_back(static_cast<float>(i * i));
  EXPECT_EQ(squared_error(levels, codebook_of(levels)), 0);
  EXPECT_EQ(io::make_scalar_codebook({})[255], 0);
}

// Numbers of a known density have the error of theory: for a Gaussian √3·π/2·σ²/n².
TEST(ScalarCodebook, ErrsAsTheorySays) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal(5, 2);
  std::vector<float> numbers(200'000);
  for (float& v : numbers) v = normal(random);
  const float mse = squared_error(numbers, codebook_of(numbers)) / 2e5F;
  EXPECT_LT(mse, 1.1 * std::sqrt(3.0) * 3.14159 / 2 * 4 / 65536);
  // A number far from all others takes one value for itself.
  numbers[7] = 1e6F;
  const io::ScalarCodebook codebook = codebook_of(numbers);
  EXPECT_LT(squared_error(numbers, codebook) / 2e5F, 1.0);
}

// Ten numbers of a million times the weight lie among ten thousand others: each has its value.
TEST(ScalarCodebook, WeightsDrawValues) {
  std::vector<float> heavy;
  std::vector<io::WeightedNumber> numbers;
  for (int i = 0; i < 10'000; ++i) numbers.push_back({static_cast<float>(i) / 10'000, 1});
  for (int i = 0; i < 10; ++i) heavy.push_back(0.05F + 0.0913F * static_cast<float>(i));
  const auto plain = io::make_scalar_codebook(numbers);
  for (const float v : heavy) numbers.push_back({v, 1e6F});
  const auto weighted = io::make_scalar_codebook(numbers);
  EXPECT_GT(squared_error(heavy, plain), 1e-6F);
  EXPECT_LT(squared_error(heavy, weighted), 1e-9F);
}

TEST(ScalarCodebook, NumbersWithoutWeightHarmNone) {
  std::vector<io::WeightedNumber> numbers;
  for (int i = 0; i < 1000; ++i) numbers.push_back({static_cast<float>(i), 0});
  for (const float v : io::make_scalar_codebook(numbers)) EXPECT_TRUE(v >= 0 && v < 1000) << v;
}

TEST(ScalarCodebook, TheNearestValueIsTaken) {
  io::ScalarCodebook codebook;
  for (int i = 0; i < 256; ++i) codebook[static_cast<std::size_t>(i)] = static_cast<float>(i);
  EXPECT_EQ(io::nearest_index(codebook, -5), 0);
  EXPECT_EQ(io::nearest_index(codebook, 3.4F), 3);
  EXPECT_EQ(io::nearest_index(codebook, 3.6F), 4);
  EXPECT_EQ(io::nearest_index(codebook, 1e9F), 255);
}

// Vectors around some centres: the palette finds these.
TEST(ShPalette, FindsClusters) {
  std::mt19937 random(2);
  std::normal_distribution<float> normal;
  constexpr std::size_t kDimensions = 9, kClusters = 40, kEach = 50;
  std::vector<float> vectors;
  for (std::size_t k = 0; k < kClusters; ++k) {
    std::vector<float> centre(kDimensions);
    for (float& v : centre) v = 10 * normal(random);
    for (std::size_t i = 0; i < kEach; ++i)
      for (const float v : centre) vectors.push_back(v + 0.01F * normal(random));
  }
  double last = 0;
  const auto palette = io::make_sh_palette(vectors, kDimensions, kClusters, [&](double part) {
    EXPECT_GE(part, last);
    EXPECT_LE(part, 1);
    last = part;
  });
  ASSERT_EQ(palette.entries.size(), kClusters * kDimensions);
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    const std::size_t label = palette.labels[i / kDimensions];
    ASSERT_NEAR(palette.entries[label * kDimensions + i % kDimensions], vectors[i], 0.08F);
  }
}

TEST(ShPalette, EqualVectorsTakeOneEntry) {
  const auto silent = [](double) {};
  const std::vector<float> zeros(9 * 5000);
  EXPECT_EQ(io::make_sh_palette(zeros, 9, 1024, silent).entries.size(), 9U);
  EXPECT_TRUE(io::make_sh_palette({}, 9, 1024, silent).entries.empty());
  const std::vector<float> huge{1e30F, 0, 0, -1e30F, 0, 0};  // whose squares are no floats
  EXPECT_LE(io::make_sh_palette(huge, 3, 2, silent).entries.size(), 6U);
}

TEST(SogWriter, ErrsAsItsLevelsSay) {
  for (const int degree : {0, 1, 2, 3}) {
    for (const std::size_t count : {std::size_t(1), std::size_t(700), std::size_t(3000)}) {
      SCOPED_TRACE(fmt::format("{} splats of degree {}", count, degree));
      SplatCloud cloud = random_cloud(count, degree, 4, 20);
      cloud.filter.compensated = degree % 2 == 1;
      FLUXGS_UNWRAP(bytes, encode_sog(cloud, "x"));
      FLUXGS_UNWRAP(again, encode_sog(cloud, "x"));
      EXPECT_TRUE(bytes == again);
      FLUXGS_UNWRAP(scene, read_sog(bytes, "x"));
      cloud = in_order(cloud, io::spatial_order(cloud.positions));
      ASSERT_EQ(scene.cloud.size(), count);
      EXPECT_EQ(scene.cloud.sh_degree, degree);
      EXPECT_EQ(scene.cloud.filter, cloud.filter);
      double scale = 0, colour = 0, sh = 0, power = 1e-9;
      for (std::size_t i = 0; i < count; ++i) {
        for (int c = 0; c < 3; ++c) {
          const double p = cloud.positions[i][c];
          const double step = 2 * std::log1p(20.0) / 65535 * (1 + std::abs(p));
          ASSERT_LE(std::abs(scene.cloud.positions[i][c] - p), 0.51 * step + 1e-6);
          scale += std::pow(scene.cloud.log_scales[i][c] - cloud.log_scales[i][c], 2);
          colour += std::pow(scene.cloud.sh_dc[i][c] - cloud.sh_dc[i][c], 2);
        }
        ASSERT_LE(
            std::abs(opacity(scene.cloud.opacity_logits[i]) - opacity(cloud.opacity_logits[i])),
            0.5 / 255 + 1e-6);
        const glm::quat a = glm::normalize(scene.cloud.rotations[i]),
                        b = glm::normalize(cloud.rotations[i]);
        ASSERT_GT(std::abs(glm::dot(a, b)), 1 - 1e-4);
      }
      for (std::size_t k = 0; k < cloud.sh_rest.size(); ++k)
        for (int c = 0; c < 3; ++c) {
          sh += std::pow(scene.cloud.sh_rest[k][c] - cloud.sh_rest[k][c], 2);
          power += std::pow(cloud.sh_rest[k][c], 2);
        }
      EXPECT_LT(scale / (3.0 * double(count)), 1e-3);
      EXPECT_LT(colour / (3.0 * double(count)), 1e-3);
      // Random vectors have nothing in common: with an entry for each, or for two, of them.
      EXPECT_LT(sh / power, count <= 1024 ? 1e-3 : 0.6);
    }
  }
}

// A few large splats are most of what one sees: their sizes are within 5%.
TEST(SogWriter, LargeSplatsKeepTheirSizes) {
  SplatCloud cloud = random_cloud(3000, 0, 4, 20);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> size(1, 4);
  for (std::size_t i = 0; i < 30; ++i) cloud.log_scales[100 * i] = glm::vec3(size(random));
  FLUXGS_UNWRAP(bytes, encode_sog(cloud, "x"));
  FLUXGS_UNWRAP(scene, read_sog(bytes, "x"));
  cloud = in_order(cloud, io::spatial_order(cloud.positions));
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (cloud.log_scales[i].x >= 1) {
      ASSERT_NEAR(scene.cloud.log_scales[i].x, cloud.log_scales[i].x, 0.05F);
    }
}

TEST(SogWriter, EdgesOfTheRange) {
  SplatCloud none;
  none.sh_degree = 1;
  FLUXGS_UNWRAP(empty, encode_sog(none, "x"));
  FLUXGS_UNWRAP(nothing, read_sog(empty, "x"));
  EXPECT_EQ(nothing.cloud.size(), 0U);
  SplatCloud cloud = random_cloud(3, 1);
  cloud.rotations = {glm::quat(0, 0, 0, 0), glm::quat(-2, 0, 0, 0), glm::quat(1e-30F, 0, 0, 0)};
  cloud.opacity_logits = {100, -100, 0};
  cloud.positions[0] = glm::vec3(std::numeric_limits<float>::max());
  cloud.log_scales[0] = glm::vec3(-1e30F);
  cloud.sh_rest[0] = glm::vec3(3e38F, -3e38F, 0);
  FLUXGS_UNWRAP(bytes, encode_sog(cloud, "x"));
  FLUXGS_UNWRAP(scene, read_sog(bytes, "x"));
  EXPECT_GE(scene.cloud.size() + scene.dropped, 3U);
  cloud = random_cloud(4, 2);
  cloud.sh_rest[3].y = std::numeric_limits<float>::quiet_NaN();
  FLUXGS_UNWRAP(fewer, encode_sog(cloud, "x"));
  FLUXGS_UNWRAP(three, read_sog(fewer, "x"));
  EXPECT_EQ(three.cloud.size(), 3U);
  cloud.rotations.pop_back();
  expect_error(encode_sog(cloud, "x.sog"), {"x.sog", "arrays disagree"});
  SplatCloud same;
  same.resize(200'000);
  expect_error(encode_sog(same, "x.sog"), {"x.sog: splats", "200000"});
}

TEST(SogWriter, ReportsItsProgress) {
  double last = 0;
  WriteOptions options;
  options.progress = [&](double part) {
    EXPECT_GE(part, last);
    last = part;
  };
  ASSERT_TRUE(encode_sog(random_cloud(2000, 3), "x", options));
  EXPECT_EQ(last, 1);
}

}  // namespace
}  // namespace fluxgs
