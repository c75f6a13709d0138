#include "sort/cpu_radix_sort.h"

#include <algorithm>
#include <array>

#include "sort/depth_keys.h"

namespace fluxgs::sort {
namespace {

constexpr int kMaxDigitBits = 11;
constexpr int kMaxPasses = (kMaxKeyBits + kMaxDigitBits - 1) / kMaxDigitBits;
using Counts = std::array<std::uint32_t, std::size_t{1} << kMaxDigitBits>;

struct Digits {
  int passes, bits;
  std::uint32_t mask;

  explicit Digits(int key_bits)
      : passes(std::max(1, (key_bits + kMaxDigitBits - 1) / kMaxDigitBits)),
        bits((std::max(1, key_bits) + passes - 1) / passes),
        mask((1U << bits) - 1) {}

  std::uint32_t of(std::uint32_t key, int pass) const { return (key >> (pass * bits)) & mask; }
};

// From how often each digit occurs to where its first key goes. Returns the number of keys.
std::uint32_t starts(Counts& counts, std::uint32_t mask) {
  std::uint32_t sum = 0;
  for (std::uint32_t d = 0; d <= mask; ++d) sum += std::exchange(counts[d], sum);
  return sum;
}

}  // namespace

std::uint32_t radix_sort(std::span<const std::uint32_t> keys, int key_bits, RadixScratch& scratch,
                         std::span<std::uint32_t> order) {
  const Digits digits(key_bits);
  std::array<Counts, kMaxPasses> counts;
  for (int pass = 0; pass < digits.passes; ++pass) counts[static_cast<std::size_t>(pass)].fill(0);
  for (const std::uint32_t key : keys) {
    if (key == kDropped) continue;
    for (int pass = 0; pass < digits.passes; ++pass)
      ++counts[static_cast<std::size_t>(pass)][digits.of(key, pass)];
  }
  std::uint32_t total = 0;
  for (int pass = 0; pass < digits.passes; ++pass)
    total = starts(counts[static_cast<std::size_t>(pass)], digits.mask);

  for (int pass = 0; pass < digits.passes; ++pass) {
    const bool last = pass + 1 == digits.passes;
    Counts& next = counts[static_cast<std::size_t>(pass)];
    auto* target = scratch.pairs_[pass % 2].data();
    const auto put = [&](std::uint32_t key, std::uint32_t index) {
      const std::uint32_t place = next[digits.of(key, pass)]++;
      if (last)
        order[total - 1 - place] = index;
      else
        target[place] = {key, index};
    };
    if (pass == 0) {
      for (std::uint32_t i = 0; i < keys.size(); ++i)
        if (keys[i] != kDropped) put(keys[i], i);
    } else {
      const auto* source = scratch.pairs_[(pass + 1) % 2].data();
      for (std::uint32_t i = 0; i < total; ++i) put(source[i].key, source[i].index);
    }
  }
  return total;
}

}  // namespace fluxgs::sort
