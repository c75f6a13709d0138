// Entropy coding of whole numbers.
#include "codec/rans.h"
#include "fluxgs/byte_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "codec/frequencies.h"

namespace fluxgs::codec {
namespace {

std::vector<std::int32_t> normal_values(std::size_t count, double deviation, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, deviation);
  std::vector<std::int32_t> values(count);
  for (std::int32_t& v : values) v = static_cast<std::int32_t>(std::lround(normal(random)));
  return values;
}

using Channels = std::vector<std::vector<std::int32_t>>;

Bytes encoded(const Channels& channels) {
  Bytes out;
  encode_values(channels, out);
  return out;
}

Expected<Channels> decode(ByteReader& in, std::size_t channels, std::size_t count) {
  if (count == 0) return Channels(channels);
  auto decoder = ValueDecoder::open(in, channels);
  if (!decoder) return std::unexpected(decoder.error());
  Channels values(channels, std::vector<std::int32_t>(count, -7));
  for (auto& channel : values)
    if (auto ok = decoder->next(channel); !ok) return std::unexpected(ok.error());
  return values;
}

void expect_round_trips(const Channels& channels) {
  const Bytes bytes = encoded(channels);
  ByteReader in(bytes);
  const auto back = decode(in, channels.size(), channels[0].size());
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(*back, channels);
  EXPECT_EQ(in.left(), 0u);
}

void expect_round_trip(const std::vector<std::int32_t>& values) { expect_round_trips({values}); }

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
  expect_round_trips({{5, 5, 5}, {1, 2, 3}, {1 << 29, 0, -7}, {0, 0, 1}});
  Channels many;
  for (unsigned seed = 0; seed < 64; ++seed) many.push_back(normal_values(777, 5, seed));
  expect_round_trips(many);
}

TEST(Rans, TakesAboutTheEntropy) {
  for (const double deviation : {0.3, 3.0, 100.0}) {
    const auto values = normal_values(100'000, deviation);
    const double bits = 8.0 * static_cast<double>(encoded({values}).size());
    EXPECT_LT(bits, 1.002 * entropy_bits(values) + 200 + 30 * deviation) << deviation;
    EXPECT_GT(bits, 0.999 * entropy_bits(values));
    // A normal distribution's entropy is log₂(σ√(2πe)) when σ is a few steps
    if (deviation >= 3) {
      EXPECT_NEAR(entropy_bits(values) / 1e5, std::log2(deviation * std::sqrt(17.0795)), 0.01);
    }
  }
}

// A table takes three bits for each distinct value of few numbers, more where it pays.
TEST(Rans, TablesAreAsExactAsItPays) {
  for (const std::size_t count : {300U, 3000U, 300'000U}) {
    const auto values = normal_values(count, 8.0);
    std::map<std::int32_t, std::uint32_t> seen;
    for (const std::int32_t v : values) ++seen[v];
    std::vector<std::uint32_t> counts;
    for (auto v = seen.begin()->first; v <= seen.rbegin()->first; ++v) counts.push_back(seen[v]);
    Bytes table;
    BitWriter out(table);
    const auto frequencies = put_frequencies(counts, out);
    out.finish();
    double bits = 0;
    for (std::size_t s = 0; s < counts.size(); ++s)
      if (counts[s] > 0) bits += counts[s] * (14 - std::log2(frequencies[s]));
    const auto for_table = 8.0 * static_cast<double>(table.size());
    const auto distinct = static_cast<double>(seen.size());
    EXPECT_LT(for_table / distinct, count < 1000 ? 4 : count < 10'000 ? 5 : 9) << count;
    EXPECT_LT(bits + for_table, entropy_bits(values) + 9 * distinct) << count;
    ByteReader in(table);
    BitReader read(in);
    const auto back = take_frequencies(read, counts.size());
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(*back, frequencies);
    EXPECT_EQ(in.left(), 0U);
  }
}

TEST(Rans, EveryCutIsAnError) {
  for (const double deviation : {2.0, 1e5}) {
    const auto values = normal_values(300, deviation);
    const Bytes bytes = encoded({values, values});
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      ByteReader in(std::span<const std::byte>(bytes).first(size));
      EXPECT_FALSE(decode(in, 2, values.size())) << size;
    }
  }
}

TEST(Rans, DamageNeverCrashesAndIsMostlyNoticed) {
  const auto values = normal_values(2000, 5.0);
  const Bytes good = encoded({values});
  std::mt19937 random(3);
  int unnoticed = 0;
  for (int round = 0; round < 2000; ++round) {
    Bytes bytes = good;
    for (unsigned k = 0; k < 1 + random() % 3; ++k)
      bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
    ByteReader in(bytes);
    const auto back = decode(in, 1, values.size());
    unnoticed += back && *back != Channels{values};
  }
  EXPECT_LT(unnoticed, 20);  // the states at the end tell nearly always
}

/// What is said of a channel whose header says `lowest` 0, and of the golomb codes of its table.
std::string error_of(unsigned raw_bits, std::size_t symbols, const std::vector<int>& table) {
  Bytes bytes;
  BitWriter out(bytes);
  out.put_golomb(0, 3);
  out.put(raw_bits, 5);
  out.put(symbols - 1, 12);
  out.put(0, 3 + 2);  // powers of two, code of order 0
  for (const int number : table) out.put_golomb(static_cast<std::uint32_t>(number), 0);
  out.finish();
  bytes.resize(bytes.size() + 64);
  ByteReader in(bytes);
  const auto done = decode(in, 1, 10);
  return done ? std::string("accepted") : done.error().what;
}

TEST(Rans, TablesThatAreNoneAreRefused) {
  EXPECT_NE(error_of(31, 2, {}).find("range"), std::string::npos);  // raw bits
  EXPECT_NE(error_of(24, 4096, {}).find("range"), std::string::npos);
  EXPECT_NE(error_of(0, 2, {1}).find("out of range"), std::string::npos);       // below 0
  EXPECT_NE(error_of(0, 2, {2 * 26}).find("out of range"), std::string::npos);  // above 2^24
  EXPECT_NE(error_of(0, 3, {2, 1, 9}).find("zeros"), std::string::npos);
  EXPECT_NE(error_of(0, 3, {0, 1, 2}).find("fewer than two"), std::string::npos);
  EXPECT_NE(error_of(0, 2, {2, 0}).find("coded values"), std::string::npos) << "a table at last";
}

}  // namespace
}  // namespace fluxgs::codec
