#include "codec/quantization.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "codec/prediction.h"

namespace fluxgs::codec {
namespace {

std::int32_t choose(double value, double weight, double rate_weight, const Prices& prices) {
  const std::int32_t near = nearest(value);
  if (near == 0 || !Prices::knows(near)) return near;
  const std::int32_t less = near > 0 ? near - 1 : near + 1;
  const auto cost = [&](std::int32_t n) {
    return weight * (value - n) * (value - n) + rate_weight * prices(n);
  };
  return cost(less) < cost(near) ? less : near;
}

/// Calls pick(difference from the prediction, index) for each value in turn.
template <class Pick>
std::vector<std::int32_t> walk(std::span<const double> values, bool predicted, const Pick& pick) {
  std::vector<std::int32_t> integers(values.size());
  Prediction prediction;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::int32_t expected = predicted ? prediction.next() : 0;
    integers[i] = pick(values[i] - expected, i);
    prediction.add(expected + integers[i]);
  }
  return integers;
}

}  // namespace

Prices::Prices(std::span<const std::int32_t> integers) : bits_(2 * kReach + 1) {
  constexpr double kUnseen = 0.1;  // what did not occur has its price, too
  std::vector<double> counts(bits_.size(), kUnseen);
  double total = kUnseen * static_cast<double>(counts.size());
  for (const std::int32_t n : integers)
    if (knows(n)) counts[index(n)] += 1, total += 1;
  const auto price = [&](double count) { return std::log2(total / count); };
  const double of_unseen = price(kUnseen);  // most of them
  std::ranges::transform(counts, bits_.begin(),
                         [&](double c) { return c == kUnseen ? of_unseen : price(c); });
}

std::vector<std::int32_t> quantize_cheaply(std::span<const double> values, bool predicted,
                                           const RateDistortion& rate_distortion) {
  auto integers = walk(values, predicted, [](double value, std::size_t) { return nearest(value); });
  if (rate_distortion.rate_weight <= 0) return integers;
  for (int pass = 0; pass < kQuantizationPasses; ++pass) {
    const Prices prices(integers);
    integers = walk(values, predicted, [&](double value, std::size_t i) {
      const double weight =
          rate_distortion.weights.empty() ? 1.0 : double{rate_distortion.weights[i]};
      return choose(value, weight, rate_distortion.rate_weight, prices);
    });
  }
  return integers;
}

}  // namespace fluxgs::codec
