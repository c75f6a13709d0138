#include "codec/frequencies.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fluxgs::codec {
namespace {

constexpr unsigned kMantissaBits = 3, kOrderBits = 2;  // of the two numbers before a table
constexpr std::uint32_t kMaxWeight = std::uint32_t{1} << 24;

/// A table's form: weights with so many bits behind the first, and the code of their levels.
struct Form {
  unsigned mantissa = 0, order = 0;
};

/// The weights that a mantissa allows are numbered from 1 on, smallest first; 0 is no weight.
std::uint32_t weight_of(std::uint32_t level, unsigned mantissa) {
  const std::uint32_t whole = 1u << mantissa;
  if (level <= whole) return level;
  const std::uint32_t above = level - 1 - whole;
  return (whole + 1 + above % whole) << (above / whole);
}

std::uint32_t max_level(unsigned mantissa) {
  return (1u << mantissa) * (25 - mantissa);  // of kMaxWeight
}

/// The level whose weight is nearest in proportion, at least 1.
std::uint32_t level_near(double weight, unsigned mantissa) {
  std::uint32_t low = 1, high = max_level(mantissa);
  while (high - low > 1) {
    const std::uint32_t middle = (low + high) / 2;
    (weight_of(middle, mantissa) <= weight ? low : high) = middle;
  }
  const double a = weight_of(low, mantissa), b = weight_of(high, mantissa);
  return weight * weight > a * b ? high : low;
}

/// All levels of a table, runs of zeros as they are.
std::vector<std::uint32_t> levels_for(std::span<const std::uint32_t> counts, unsigned mantissa) {
  const double most = *std::ranges::max_element(counts);
  const double factor = std::min(1.0, kMaxWeight / most);
  std::vector<std::uint32_t> levels(counts.size(), 0);
  for (std::size_t s = 0; s < counts.size(); ++s)
    if (counts[s] > 0) levels[s] = level_near(counts[s] * factor, mantissa);
  return levels;
}

std::vector<std::uint32_t> frequencies_of(std::span<const std::uint32_t> levels,
                                          unsigned mantissa) {
  std::vector<std::uint32_t> scaled(levels.size(), 0);
  std::uint64_t total = 0;
  for (const std::uint32_t level : levels) total += weight_of(level, mantissa);
  std::int64_t left = kFrequencySum;
  for (std::size_t s = 0; s < levels.size(); ++s) {
    if (levels[s] == 0) continue;
    const std::uint64_t weight = weight_of(levels[s], mantissa);
    scaled[s] = std::max(1u, static_cast<std::uint32_t>(weight * kFrequencySum / total));
    left -= scaled[s];
  }
  // What rounding left over or overspent is taken where it costs least: at the largest
  while (left != 0) {
    const auto largest = std::ranges::max_element(scaled);
    const std::int64_t step = left > 0 ? left : -std::min<std::int64_t>(-left, (*largest - 1) / 2);
    *largest = static_cast<std::uint32_t>(*largest + step);
    left -= step;
  }
  return scaled;
}

/// Tells `put(number, order)` what a table is made of: each level as its difference from the one
/// before, a run of zeros as one zero and how many follow.
template <class Put>
void describe(std::span<const std::uint32_t> levels, unsigned order, Put&& put) {
  std::uint32_t before = 0;
  for (std::size_t s = 0; s < levels.size(); ++s) {
    const auto difference = std::int64_t{levels[s]} - std::int64_t{before};
    put(static_cast<std::uint32_t>(zigzag(difference)), order);
    before = levels[s];
    if (before > 0) continue;
    const std::size_t first = s;
    while (s + 1 < levels.size() && levels[s + 1] == 0) ++s;
    put(static_cast<std::uint32_t>(s - first), 0);
  }
}

double bits_of(std::span<const std::uint32_t> levels, unsigned order) {
  double bits = 0;
  describe(levels, order, [&](std::uint32_t v, unsigned k) { bits += golomb_bits(v, k); });
  return bits;
}

double coded_bits(std::span<const std::uint32_t> counts,
                  std::span<const std::uint32_t> frequencies) {
  double bits = 0;
  for (std::size_t s = 0; s < counts.size(); ++s)
    if (counts[s] > 0) bits += counts[s] * (kScaleBits - std::log2(double(frequencies[s])));
  return bits;
}

}  // namespace

std::vector<std::uint32_t> put_frequencies(std::span<const std::uint32_t> counts, BitWriter& out) {
  Form best;
  std::vector<std::uint32_t> levels, frequencies;
  double fewest = std::numeric_limits<double>::infinity();
  for (unsigned mantissa = 0; mantissa < (1u << kMantissaBits); ++mantissa) {
    auto tried = levels_for(counts, mantissa);
    auto made = frequencies_of(tried, mantissa);
    const double symbols = coded_bits(counts, made);
    for (unsigned order = 0; order < (1u << kOrderBits); ++order) {
      const double bits = symbols + bits_of(tried, order);
      if (bits >= fewest) continue;
      fewest = bits;
      best = {mantissa, order};
      levels = tried;
      frequencies = made;
    }
  }
  out.put(best.mantissa, kMantissaBits);
  out.put(best.order, kOrderBits);
  describe(levels, best.order, [&](std::uint32_t v, unsigned k) { out.put_golomb(v, k); });
  return frequencies;
}

Expected<std::vector<std::uint32_t>> take_frequencies(BitReader& in, std::size_t symbols) {
  const auto mantissa = in.take(kMantissaBits), order = in.take(kOrderBits);
  if (!mantissa || !order) return fail("", "", "the table of frequencies is cut off");
  std::vector<std::uint32_t> levels(symbols, 0);
  std::int64_t level = 0;
  for (std::size_t s = 0; s < symbols; ++s) {
    const auto difference = in.take_golomb(*order);
    if (!difference) return fail("", "", "the table of frequencies is cut off");
    level += unzigzag(*difference);
    if (level < 0 || level > max_level(*mantissa))
      return fail("", "", "the table of frequencies has one out of range");
    levels[s] = static_cast<std::uint32_t>(level);
    if (level > 0) continue;
    const auto more = in.take_golomb(0);
    if (!more || *more >= symbols - s)
      return fail("", "", "the table of frequencies has a run of zeros that does not fit");
    s += *more;
  }
  if (std::ranges::count(levels, 0u) > static_cast<std::ptrdiff_t>(symbols) - 2)
    return fail("", "", "the table of frequencies has fewer than two symbols");
  return frequencies_of(levels, *mantissa);
}

}  // namespace fluxgs::codec
