// Coding of an attribute: what is lost, what it takes, and damaged streams.
#include "codec/channels.h"
#include "fluxgs/byte_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace fluxgs::codec {
namespace {

/// Correlated channels that change slowly from splat to splat.
Channels smooth(std::size_t splats, std::size_t channels, float noise, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  Channels input{channels, std::vector<float>(splats * channels), {}};
  for (std::size_t i = 0; i < splats; ++i) {
    const float common = 3 * std::sin(0.01f * static_cast<float>(i)) + 0.3f * normal(random);
    for (std::size_t c = 0; c < channels; ++c)
      input.values[i * channels + c] =
          common * (1 + 0.2f * static_cast<float>(c)) + noise * normal(random) + 5;
  }
  return input;
}

Bytes encoded(const Channels& input, float step) {
  Bytes out;
  const auto done = encode_channels(input, step, {}, out);
  EXPECT_TRUE(done) << done.error().message();
  return out;
}

/// What is decoded channel by channel, splat by splat.
std::vector<float> by_splat(const std::vector<float>& planes, std::size_t channels) {
  std::vector<float> result(planes.size());
  const std::size_t splats = planes.size() / channels;
  for (std::size_t i = 0; i < splats; ++i)
    for (std::size_t c = 0; c < channels; ++c) result[i * channels + c] = planes[c * splats + i];
  return result;
}

TEST(Channels, ErrorsAreThoseOfTheStep) {
  for (const std::size_t channels : {1u, 3u, 9u, 45u}) {
    for (const float step : {0.5f, 0.01f}) {
      const Channels input = smooth(2000, channels, 0.2f);
      const Bytes bytes = encoded(input, step);
      ByteReader in(bytes);
      std::vector<float> back(input.values.size());
      const auto done = decode_channels(in, channels, {}, back);
      ASSERT_TRUE(done) << done.error().message();
      EXPECT_EQ(in.left(), 0u);
      back = by_splat(back, channels);
      double worst = 0, squares = 0;
      for (std::size_t i = 0; i < back.size(); ++i) {
        const double error = std::abs(double{back[i]} - double{input.values[i]});
        worst = std::max(worst, error);
        squares += error * error;
      }
      const double s = double{step};
      EXPECT_LE(worst, 0.5 * s * std::sqrt(static_cast<double>(channels)) + 1e-5);
      EXPECT_NEAR(std::sqrt(squares / static_cast<double>(back.size())), s / std::sqrt(12),
                  0.05 * s);
    }
  }
}

TEST(Channels, CorrelationAndNeighboursMakeItSmaller) {
  const float step = 0.05f;
  const Channels together = smooth(20'000, 3, 0.02f);
  double apart = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    Channels one{1, {}, {}};
    for (std::size_t i = 0; i < together.splats(); ++i)
      one.values.push_back(together.values[3 * i + c]);
    apart += *channels_bits(one, step);
  }
  EXPECT_LT(*channels_bits(together, step), 0.7 * apart);
  const double claimed = *channels_bits(together, step);
  EXPECT_NEAR(8.0 * static_cast<double>(encoded(together, step).size()), claimed, 0.02 * claimed);
  Channels shuffled = together;  // whole splats
  std::mt19937 random(5);
  for (std::size_t i = together.splats(); i > 1; --i)
    for (std::size_t c = 0, j = random() % i; c < 3; ++c)
      std::swap(shuffled.values[3 * (i - 1) + c], shuffled.values[3 * j + c]);
  EXPECT_GT(*channels_bits(shuffled, step), 1.02 * claimed);
}

TEST(Channels, OneSplatAndEqualSplats) {
  for (const std::size_t splats : {1u, 2u, 500u}) {
    const Channels input{3, std::vector<float>(3 * splats, -2.5f), {}};
    const Bytes bytes = encoded(input, 0.1f);
    ByteReader in(bytes);
    std::vector<float> back(input.values.size());
    ASSERT_TRUE(decode_channels(in, 3, {}, back));
    for (const float v : back) EXPECT_NEAR(v, -2.5f, 1e-5);
  }
}

TEST(Channels, CoarseSplatsLoseMore) {
  Channels input = smooth(4000, 3, 0.2f);
  for (std::size_t i = 0; i < input.splats(); ++i) input.step_scale.push_back(i % 2 ? 4.0f : 1.0f);
  const Bytes bytes = encoded(input, 0.05f);
  ByteReader in(bytes);
  std::vector<float> back(input.values.size());
  ASSERT_TRUE(decode_channels(in, 3, input.step_scale, back));
  back = by_splat(back, 3);
  double squares[2] = {0, 0};
  for (std::size_t i = 0; i < back.size(); ++i) {
    const double error = double{back[i]} - double{input.values[i]};
    squares[i / 3 % 2] += error * error / 6000;
  }
  EXPECT_NEAR(std::sqrt(squares[0]), 0.05 / std::sqrt(12), 0.002);
  EXPECT_NEAR(std::sqrt(squares[1]), 0.20 / std::sqrt(12), 0.008);
}

TEST(Channels, TooSmallAStepIsAnError) {
  Bytes out;
  EXPECT_FALSE(encode_channels({1, {0, 1e9f}, {}}, 1e-3f, {}, out));
}

// Sums of products of it would overflow where it is decoded
TEST(Channels, MeansBeyondTheFormatAreAnError) {
  const Channels input{1, std::vector<float>(4, 1e31f), {}};
  Bytes out;
  const auto done = encode_channels(input, 1e30f, {}, out);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().what.find("its mean is 1e+31, expected less than 1e+30"),
            std::string::npos)
      << done.error().what;
}

TEST(Channels, CutsAndDamage) {
  const Channels input = smooth(200, 3, 0.2f);
  const Bytes good = encoded(input, 0.1f);
  std::vector<float> back(input.values.size());
  for (std::size_t size = 0; size < good.size(); ++size) {
    ByteReader in(std::span<const std::byte>(good).first(size));
    EXPECT_FALSE(decode_channels(in, 3, {}, back)) << size;
  }
  ByteReader wrong(good);
  EXPECT_FALSE(decode_channels(wrong, 4, {}, back));
  std::mt19937 random(9);
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes = good;
    bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
    ByteReader in(bytes);
    if (!decode_channels(in, 3, {}, back)) continue;
    for (const float v : back) ASSERT_TRUE(std::isfinite(v));
  }
}

}  // namespace
}  // namespace fluxgs::codec
