// Prediction of integers from those before them.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fluxgs::codec {

/// The rounded mean of the (up to) four values before; their sum is kept as it moves.
class Prediction {
 public:
  std::int32_t next() const {
    if (count_ == kMemory) return static_cast<std::int32_t>((sum_ + 2) >> 2);  // the same, but fast
    if (count_ == 0) return 0;
    const std::int64_t twice = 2 * sum_ + count_;  // rounds halves up, also below zero
    const std::int64_t by = 2 * count_;
    return static_cast<std::int32_t>(twice >= 0 ? twice / by : -((-twice + by - 1) / by));
  }
  void add(std::int32_t value) {
    std::int32_t& oldest = recent_[at_];
    if (count_ == kMemory)
      sum_ -= oldest;
    else
      ++count_;
    sum_ += oldest = value;
    at_ = (at_ + 1) % std::size_t{kMemory};
  }

 private:
  static constexpr std::int64_t kMemory = 4;
  std::int32_t recent_[kMemory] = {};
  std::size_t at_ = 0;
  std::int64_t sum_ = 0, count_ = 0;
};

}  // namespace fluxgs::codec
