// The sorts of keys, on the GPU and on the CPU, against std::stable_sort.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <map>
#include <memory>
#include <numeric>
#include <random>

#include "gl_fixture.h"
#include "sort/cpu_radix_sort.h"
#include "sort/gpu_radix_sorter.h"

namespace fluxgs::test {
namespace {

using Keys = std::vector<std::uint32_t>;

// What Sorter promises: the reverse of a stable ascending sort, without the dropped.
Keys expected_order(const Keys& keys) {
  Keys order(keys.size());
  std::iota(order.begin(), order.end(), 0U);
  std::erase_if(order, [&](std::uint32_t i) { return keys[i] == sort::kDropped; });
  std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return keys[i]; });
  std::ranges::reverse(order);
  return order;
}

class SorterTest : public GlTest {
 protected:
  static constexpr std::uint32_t kSpare = 128;

  void expect_sorted(sort::GpuRadixSorter& sorter, const Keys& keys, const std::string& label,
                     int key_bits = 32) {
    const auto count = static_cast<std::uint32_t>(keys.size());
    const gl::Buffer source =
        must(gl::Buffer::create(api(), keys.size() * sizeof(keys[0]), keys.data()));
    sorter.sort_keys(source, count, key_bits);
    const Keys expected = expected_order(keys);
    ASSERT_EQ(must(sorter.count().read_all<std::uint32_t>(1)).front(), expected.size()) << label;
    EXPECT_EQ(must(sorter.order().read_all<std::uint32_t>(expected.size())), expected) << label;
  }

  // One for each width of digits: its programs take seconds on some drivers.
  sort::GpuRadixSorter& sorter_for(const Keys& keys, int digit_bits) {
    auto& sorter = sorters_[digit_bits];
    if (!sorter) sorter = must(sort::GpuRadixSorter::create(api(), digit_bits));
    must(sorter->set_scene(static_cast<std::uint32_t>(keys.size()), kSpare, {}));
    return *sorter;
  }

  // The GPU's sort with several digits, and the CPU's.
  void for_all_sorts(const Keys& keys, const std::string& label, int key_bits = 32) {
    for (const int bits : {4, 7, 8}) {
      expect_sorted(sorter_for(keys, bits), keys, label + ", " + std::to_string(bits) + " bits",
                    key_bits);
    }
    sort::RadixScratch scratch(keys.size());
    Keys order(keys.size());
    order.resize(sort::radix_sort(keys, key_bits, scratch, order));
    EXPECT_EQ(order, expected_order(keys)) << label << ", CPU";
  }

  void TearDown() override {
    sorters_.clear();
    GlTest::TearDown();
  }

 private:
  std::map<int, std::unique_ptr<sort::GpuRadixSorter>> sorters_;
};

Keys random_keys(std::size_t count, std::uint32_t below, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<std::uint32_t> key(0, below - 1);
  Keys keys(count);
  for (std::uint32_t& k : keys) k = key(random);
  return keys;
}

TEST_P(SorterTest, EverySizeAroundTheBlocks) {
  const std::size_t sizes[] = {0,    1,    2,    31,   32,   33,   255,   256,  257,
                               2047, 2048, 2049, 4095, 4096, 4097, 32768, 32769};
  for (const int bits : {4, 5, 6, 7, 8}) {
    const auto sorter = must(sort::GpuRadixSorter::create(api(), bits));
    must(sorter->set_scene(32769, kSpare, {}));
    for (const std::size_t size : sizes)
      expect_sorted(*sorter, random_keys(size, sort::kDropped, 1),
                    std::to_string(size) + " keys, " + std::to_string(bits) + " bits");
  }
}

TEST_P(SorterTest, AHundredThousand) {
  for_all_sorts(random_keys(100'000, sort::kDropped, 2), "random");
}

TEST_P(SorterTest, EqualKeysStayInOrder) {
  for_all_sorts(Keys(5000, 0), "all 0");
  for_all_sorts(Keys(5000, 0xFFFFFFFEU), "all at the maximum");
  for_all_sorts(random_keys(20'000, 3, 3), "three values");
}

TEST_P(SorterTest, SortedAndReversedInput) {
  Keys keys(10'000);
  std::iota(keys.begin(), keys.end(), 0x12345678U);
  for_all_sorts(keys, "ascending");
  std::ranges::reverse(keys);
  for_all_sorts(keys, "descending");
}

// Each digit alone decides: a pass that reads the wrong one cannot hide.
TEST_P(SorterTest, EveryBitCounts) {
  Keys keys;
  for (std::uint32_t bit = 0; bit < 32; ++bit) keys.push_back(1U << bit);
  for (std::uint32_t bit = 0; bit < 31; ++bit) keys.push_back(~(1U << bit));
  std::shuffle(keys.begin(), keys.end(), std::mt19937(4));
  for_all_sorts(keys, "bits");
}

TEST_P(SorterTest, DroppedKeysAreLeftOutInOrder) {
  for (const std::size_t size : {1, 256, 2048, 2049, 30'000}) {
    for (const std::uint32_t keep_one_in : {2U, 7U, 2048U}) {
      Keys keys = random_keys(size, 100, 5);
      for (std::size_t i = 0; i < size; ++i)
        if (i % keep_one_in != 0) keys[i] = sort::kDropped;
      for_all_sorts(keys, std::to_string(size) + ", one in " + std::to_string(keep_one_in));
    }
    for_all_sorts(Keys(size, sort::kDropped), "all dropped");
  }
}

// Bits of positive floats are ordered like the floats: the keys that the renderer uses.
TEST_P(SorterTest, DepthsAsKeys) {
  std::mt19937 random(6);
  std::lognormal_distribution<float> depth(0.0F, 8.0F);
  Keys keys(3000);
  std::vector<float> depths(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    depths[i] = depth(random);
    keys[i] = std::bit_cast<std::uint32_t>(depths[i]);
  }
  const Keys order = expected_order(keys);
  EXPECT_TRUE(std::ranges::is_sorted(order, std::greater{}, [&](auto i) { return depths[i]; }));
  for_all_sorts(keys, "depths");
}

TEST_P(SorterTest, TheSameSorterServesFrameAfterFrame) {
  const auto sorter = must(sort::GpuRadixSorter::create(api(), 8));
  must(sorter->set_scene(9000, kSpare, {}));
  for (const std::size_t size : {9000, 10, 5000, 0, 9000})
    expect_sorted(*sorter, random_keys(size, 50, static_cast<std::uint32_t>(size)),
                  "frame of " + std::to_string(size));
}

// Every number of passes, with the key's last bit in every place of the last digit.
TEST_P(SorterTest, NarrowKeys) {
  for (const int bits : {10, 12, 14, 16, 17, 20, 21, 22, 24, 28, 31}) {
    const Keys keys = random_keys(3000, 1U << bits, static_cast<std::uint32_t>(bits));
    for_all_sorts(keys, std::to_string(bits) + "-bit keys", bits);
  }
}

TEST_P(SorterTest, OtherDigitWidthsAreRefused) {
  const auto sorter = sort::GpuRadixSorter::create(api(), 9);
  ASSERT_FALSE(sorter);
  EXPECT_EQ(sorter.error().field, "digit_bits");
}

FLUXGS_GL_TEST_SUITE(SorterTest);

}  // namespace
}  // namespace fluxgs::test
