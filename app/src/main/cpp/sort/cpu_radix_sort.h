// The radix sort of the CPU, as fast as one core does it.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace fluxgs::sort {

/// The room that radix_sort() works in. Made once for a scene.
class RadixScratch {
 public:
  explicit RadixScratch(std::size_t count) : pairs_{Pairs(count), Pairs(count)} {}
  RadixScratch() = default;

 private:
  struct Pair {
    std::uint32_t key, index;
  };
  using Pairs = std::vector<Pair>;
  friend std::uint32_t radix_sort(std::span<const std::uint32_t> keys, int key_bits,
                                  RadixScratch& scratch, std::span<std::uint32_t> order);
  Pairs pairs_[2];
};

/// Writes the indices of the keys that are not kDropped to `order`, the largest key first and among
/// equal keys the largest index first, and returns how many there are: the same as every Sorter.
/// `key_bits`: all other keys are smaller than 2^key_bits. Both spans and the scratch have room for
/// all keys. Least-significant-digit first, digits of at most 11 bits so that the counts stay in
/// the first-level cache.
std::uint32_t radix_sort(std::span<const std::uint32_t> keys, int key_bits, RadixScratch& scratch,
                         std::span<std::uint32_t> order);

}  // namespace fluxgs::sort
