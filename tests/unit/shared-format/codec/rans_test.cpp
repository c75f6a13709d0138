// Entropy coding of whole numbers.
#include "codec/rans.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace fluxgs::codec {
namespace {

std::vector<std::int32_t> normal_values(std::size_t count, double deviation, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, deviation);
  std::vector<std::int32_t> values(count);
  for (std::int32_t& v : values) v = static_cast<std::int32_t>(std::lround(normal(random)));
  return values;
}

Bytes encoded(const std::vector<std::int32_t>& values) {
  Bytes out;
  encode_values(values, out);
  return out;
}

void expect_round_trip(const std::vector<std::int32_t>& values) {
  const Bytes bytes = encoded(values);
  Reader in(bytes);
  std::vector<std::int32_t> back(values.size(), -7);
  const auto done = decode_values(in, back);
  ASSERT_TRUE(done) << done.error().message();
  EXPECT_EQ(back, values);
  EXPECT_EQ(in.left(), 0u);
}

TEST(Rans, RoundTrips) {
  expect_round_trip({});
  expect_round_trip({0});
  expect_round_trip({-5, -5, -5, -5});
  expect_round_trip({1, 2});
  expect_round_trip({1 << 29, -(1 << 29), 0, 12345});
  for (const double deviation : {0.1, 1.0, 30.0, 1e4, 1e7}) {
    expect_round_trip(normal_values(1, deviation));
    expect_round_trip(normal_values(10001, deviation));
  }
  std::vector<std::int32_t> rare(5000, 0);  // one symbol in nearly all places
  rare[17] = 4000;
  expect_round_trip(rare);
  std::vector<std::int32_t> flat(8192);
  for (std::size_t i = 0; i < flat.size(); ++i) flat[i] = static_cast<std::int32_t>(i % 4096);
  expect_round_trip(flat);
}

TEST(Rans, TakesAboutTheEntropy) {
  for (const double deviation : {0.3, 3.0, 100.0}) {
    const auto values = normal_values(100'000, deviation);
    const double bits = 8.0 * static_cast<double>(encoded(values).size());
    EXPECT_LT(bits, 1.005 * entropy_bits(values) + 20 * 8 * (1 + deviation)) << deviation;
    EXPECT_GT(bits, 0.999 * entropy_bits(values));
    // A normal distribution's entropy is log₂(σ√(2πe)) when σ is a few steps
    if (deviation >= 3) {
      EXPECT_NEAR(entropy_bits(values) / 1e5, std::log2(deviation * std::sqrt(17.0795)), 0.01);
    }
  }
}

TEST(Rans, EveryCutIsAnError) {
  for (const double deviation : {2.0, 1e5}) {
    const auto values = normal_values(300, deviation);
    const Bytes bytes = encoded(values);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      Reader in(std::span<const std::byte>(bytes).first(size));
      std::vector<std::int32_t> back(values.size());
      EXPECT_FALSE(decode_values(in, back)) << size;
    }
  }
}

TEST(Rans, DamageNeverCrashesAndIsMostlyNoticed) {
  const auto values = normal_values(2000, 5.0);
  const Bytes good = encoded(values);
  std::mt19937 random(3);
  int unnoticed = 0;
  for (int round = 0; round < 2000; ++round) {
    Bytes bytes = good;
    for (unsigned k = 0; k < 1 + random() % 3; ++k)
      bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
    Reader in(bytes);
    std::vector<std::int32_t> back(values.size());
    unnoticed += decode_values(in, back).has_value() && back != values;
  }
  EXPECT_LT(unnoticed, 20);  // the states at the end tell nearly always
}

TEST(Rans, TablesThatAreNoneAreRefused) {
  const auto error_of = [](const std::vector<int>& numbers) {
    Bytes bytes;
    for (const int n : numbers) put_varint(bytes, static_cast<std::uint64_t>(n));
    bytes.resize(bytes.size() + 64);
    Reader in(bytes);
    std::vector<std::int32_t> back(10);
    const auto done = decode_values(in, back);
    return done ? std::string("accepted") : done.error().what;
  };
  EXPECT_NE(error_of({0, 0, 0}).find("range"), std::string::npos);     // no symbols
  EXPECT_NE(error_of({0, 0, 5000}).find("range"), std::string::npos);  // too many
  EXPECT_NE(error_of({0, 60, 2}).find("range"), std::string::npos);    // raw bits
  EXPECT_NE(error_of({0, 0, 2, 16000, 600}).find("more than"), std::string::npos);
  EXPECT_NE(error_of({0, 0, 2, 16000, 100}).find("less than"), std::string::npos);
  EXPECT_NE(error_of({0, 0, 3, 100, 0, 9}).find("zeros"), std::string::npos);
}

}  // namespace
}  // namespace fluxgs::codec
