// Functions that what is decoded depends on, with the same bits on every machine. C libraries
// differ in their last bits (glibc, musl and bionic do); these are made of additions,
// multiplications and divisions of doubles alone, which are rounded as IEEE 754 says. They have no
// branches, so that compilers vectorise loops over them. Relative errors are below 10⁻¹⁵.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace fluxgs::codec {

namespace detail {

constexpr int kExponentAt = 52;                    // of a double's bits
constexpr double kLn2High = 0x1.62e42feep-1;       // has room for a product with an exponent
constexpr double kLn2Low = 0x1.a39ef35793c76p-33;  // ln 2 = kLn2High + kLn2Low
constexpr double kLog2E = 1.442695040888963407;

/// first + x·(second + x·(…)).
template <std::size_t N>
constexpr double polynomial(const double (&coefficients)[N], double x) {
  double sum = coefficients[N - 1];
  for (std::size_t i = N - 1; i-- > 0;) sum = sum * x + coefficients[i];
  return sum;
}

}  // namespace detail

/// The natural logarithm of 2⁻¹⁰⁰⁰ … 2¹⁰⁰⁰.
inline double portable_log(double x) {
  // x = 2ᵏ·m with √½ ≤ m < √2; the bits of a double are about those of its logarithm
  constexpr std::uint64_t kRootOfHalf = 0x3fe6a09e667f3bcd, kBias = 1024;
  constexpr std::uint64_t kAbove = (kBias << detail::kExponentAt) - kRootOfHalf;
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const std::uint64_t biased = (bits + kAbove) >> detail::kExponentAt;  // k + 1024
  const double m = std::bit_cast<double>(bits - (biased << detail::kExponentAt) +
                                         (kBias << detail::kExponentAt));
  const double k = std::bit_cast<double>(std::bit_cast<std::uint64_t>(0x1p52) | biased) -
                   (0x1p52 + double{kBias});
  // ln m = 2·artanh s, as f less what is small, so that little is rounded
  constexpr double kSeries[] = {2 / 3.0,  2 / 5.0,  2 / 7.0,  2 / 9.0, 2 / 11.0,
                                2 / 13.0, 2 / 15.0, 2 / 17.0, 2 / 19.0};
  const double f = m - 1, s = f / (m + 1), z = s * s, half = 0.5 * f * f;
  const double small =
      half - (s * (half + z * detail::polynomial(kSeries, z)) + k * detail::kLn2Low);
  return k * detail::kLn2High - (small - f);
}

/// The exponential of −700 … 700.
inline double portable_exp(double x) {
  // x = k·ln 2 + r; added to kRound, k is in the lowest bits
  constexpr double kRound = 0x1.8p52;
  const double shifted = x * detail::kLog2E + kRound, k = shifted - kRound;
  const double r = (x - k * detail::kLn2High) - k * detail::kLn2Low;
  constexpr double kSeries[] = {1 / 2.0,       1 / 6.0,        1 / 24.0,        1 / 120.0,
                                1 / 720.0,     1 / 5040.0,     1 / 40320.0,     1 / 362880.0,
                                1 / 3628800.0, 1 / 39916800.0, 1 / 479001600.0, 1 / 6227020800.0};
  const double power = 1 + (r + r * r * detail::polynomial(kSeries, r));
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(power) +
                               (std::bit_cast<std::uint64_t>(shifted) << detail::kExponentAt));
}

/// The sine of −π/2 … π/2.
inline double portable_sin(double x) {
  constexpr double kSeries[] = {-1 / 6.0,
                                1 / 120.0,
                                -1 / 5040.0,
                                1 / 362880.0,
                                -1 / 39916800.0,
                                1 / 6227020800.0,
                                -1 / 1307674368000.0,
                                1 / 355687428096000.0,
                                -1 / 121645100408832000.0,
                                1 / 51090942171709440000.0};
  const double z = x * x;
  return x + x * (z * detail::polynomial(kSeries, z));
}

}  // namespace fluxgs::codec
