// The codec's own logarithm, exponential and sine: as exact as those of a C library, and the same
// bits everywhere.
#include "codec/deterministic_math.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>

namespace fluxgs::codec {
namespace {

constexpr double kRelative = 1e-15;

TEST(DeterministicMath, LogarithmIsExact) {
  for (double x = 1e-30; x < 1e30; x *= 1.0137)
    EXPECT_NEAR(portable_log(x), std::log(x), kRelative * std::abs(std::log(x))) << x;
  for (int i = -1000; i <= 1000; ++i) {
    const double x = 1 + i * 1e-6;
    EXPECT_NEAR(portable_log(x), std::log(x), kRelative * std::abs(std::log(x))) << x;
  }
}

TEST(DeterministicMath, ExponentialIsExact) {
  for (double x = -700; x <= 700; x += 0.137)
    EXPECT_NEAR(portable_exp(x), std::exp(x), kRelative * std::exp(x)) << x;
}

TEST(DeterministicMath, SineIsExact) {
  for (int i = -1000; i <= 1000; ++i) {
    const double x = i * std::numbers::pi / 2000;
    EXPECT_NEAR(portable_sin(x), std::sin(x), kRelative * std::abs(std::sin(x))) << x;
  }
}

// FNV-1a of all results, of the compiler and the machine that they were first computed on
TEST(DeterministicMath, HasTheSameBitsEverywhere) {
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](double x) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x100000001b3;
  };
  for (int i = 1; i <= 4096; ++i) {
    add(portable_log(i / 64.0));
    add(portable_exp(i / 64.0 - 32));
    add(portable_sin(i / 4096.0));
  }
  EXPECT_EQ(hash, 0x62f74aa5893bb9d3);
}

}  // namespace
}  // namespace fluxgs::codec
