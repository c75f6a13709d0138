// Prediction of integers from those before them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace fluxgs::codec {

/// The rounded mean of the (up to) four values before; their sum is kept as it moves.
class Prediction {
 public:
  static constexpr std::int64_t kMemory = 4;

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
  std::int32_t recent_[kMemory] = {};
  std::size_t at_ = 0;
  std::int64_t sum_ = 0, count_ = 0;
};

/// Adds its prediction to each value. Damaged streams may leave the range: wraps instead of
/// overflowing.
inline void add_predictions(std::span<std::int32_t> values) {
  const auto sum_of = [](std::int32_t difference, std::int32_t expected) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(difference) +
                                     static_cast<std::uint32_t>(expected));
  };
  constexpr auto kMemory = static_cast<std::size_t>(Prediction::kMemory);
  Prediction prediction;
  std::int64_t sum = 0;
  for (std::int32_t& value : values.first(std::min(values.size(), kMemory))) {
    value = sum_of(value, prediction.next());
    prediction.add(value);
    sum += value;
  }
  // The same as with Prediction, but each waits for the one before a shorter time
  for (std::size_t i = kMemory; i < values.size(); ++i) {
    values[i] = sum_of(values[i], static_cast<std::int32_t>((sum + 2) >> 2));
    sum = (sum - values[i - kMemory]) + values[i];
  }
}

}  // namespace fluxgs::codec
