#include "io/sog/scalar_codebook.h"

#include <algorithm>
#include <cmath>
#include <ranges>
#include <span>

namespace fluxgs::io {
namespace {

constexpr int kIterations = 2000;  // of microseconds each; it ends when nothing moves

// Centres with equal parts of the integral of the cube root of a histogram between them.
ScalarCodebook companded(std::span<const WeightedNumber> sorted) {
  constexpr std::size_t kBins = 1024;
  const double low = sorted.front().number, width = (double{sorted.back().number} - low) / kBins;
  std::vector<double> sums(kBins + 1);
  for (const WeightedNumber& v : sorted) {
    const auto bin = static_cast<std::size_t>((v.number - low) / width);
    sums[std::min(bin, kBins - 1) + 1] += double{v.weight};
  }
  for (std::size_t b = 1; b <= kBins; ++b) sums[b] = sums[b - 1] + std::cbrt(sums[b]);
  ScalarCodebook centres;
  std::size_t bin = 0;
  for (std::size_t k = 0; k < centres.size(); ++k) {
    const double part = (static_cast<double>(k) + 0.5) / static_cast<double>(centres.size());
    const double wanted = part * sums[kBins];
    while (bin + 1 < kBins && sums[bin + 1] < wanted) ++bin;
    const double inside = (wanted - sums[bin]) / std::max(sums[bin + 1] - sums[bin], 1e-300);
    centres[k] = static_cast<float>(low + width * (static_cast<double>(bin) + inside));
  }
  return centres;
}

// Sums over the numbers before each one, and over all.
struct Sums {
  explicit Sums(std::span<const WeightedNumber> sorted)
      : weights(sorted.size() + 1), products(sorted.size() + 1) {
    for (std::size_t i = 0; i < sorted.size(); ++i) {
      const double weight = sorted[i].weight;
      weights[i + 1] = weights[i] + weight;
      products[i + 1] = products[i] + weight * sorted[i].number;
    }
  }

  std::vector<double> weights, products;
};

// One step: each centre to the mean of the numbers that are nearest to it. True if any moved.
bool improve(ScalarCodebook& centres, std::span<const WeightedNumber> sorted, const Sums& sums) {
  bool moved = false;
  std::size_t begin = 0;
  ScalarCodebook next = centres;
  for (std::size_t k = 0; k < centres.size(); ++k) {
    std::size_t end = sorted.size();
    if (k + 1 < centres.size()) {
      const double middle = (double{centres[k]} + centres[k + 1]) / 2;
      end = static_cast<std::size_t>(
          std::ranges::lower_bound(sorted, middle, {}, &WeightedNumber::number) - sorted.begin());
    }
    if (end > begin) {
      const double weight = sums.weights[end] - sums.weights[begin];
      if (weight > 0)
        next[k] = static_cast<float>((sums.products[end] - sums.products[begin]) / weight);
    }
    moved |= next[k] != centres[k];
    begin = std::max(begin, end);
  }
  centres = next;
  return moved;
}

}  // namespace

ScalarCodebook make_scalar_codebook(std::vector<WeightedNumber> numbers) {
  ScalarCodebook codebook{};
  if (numbers.empty()) return codebook;
  std::ranges::sort(numbers, {}, &WeightedNumber::number);
  std::vector<float> different;
  std::ranges::unique_copy(numbers | std::views::transform(&WeightedNumber::number),
                           std::back_inserter(different));
  if (different.size() <= codebook.size()) {
    codebook.fill(different.back());
    std::ranges::copy(different, codebook.begin());
    return codebook;
  }
  const Sums sums(numbers);
  codebook = companded(numbers);
  for (int i = 0; i < kIterations && improve(codebook, numbers, sums); ++i) {
  }
  std::ranges::sort(codebook);
  return codebook;
}

std::uint8_t nearest_index(const ScalarCodebook& codebook, float number) {
  const auto above = std::ranges::lower_bound(codebook, number);
  if (above == codebook.begin()) return 0;
  const auto below = above - 1;
  const bool up = above != codebook.end() && *above - number < number - *below;
  return static_cast<std::uint8_t>((up ? above : below) - codebook.begin());
}

}  // namespace fluxgs::io
