// Rounding to integers that take few bits.
#include "codec/quantization.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "codec/prediction.h"
#include "codec/rans.h"

namespace fluxgs::codec {
namespace {

std::vector<double> laplacian(std::size_t count, double scale) {
  std::mt19937 random(3);
  std::exponential_distribution<double> size(1 / scale);
  std::vector<double> values(count);
  for (double& v : values) v = (random() % 2 == 0 ? 1 : -1) * size(random);
  return values;
}

/// What a decoder makes of the numbers.
std::vector<double> restored(const std::vector<std::int32_t>& numbers, bool predicted) {
  Prediction prediction;
  std::vector<double> values;
  for (const std::int32_t n : numbers) {
    const std::int32_t value = n + (predicted ? prediction.next() : 0);
    prediction.add(value);
    values.push_back(value);
  }
  return values;
}

double mean_square(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum / static_cast<double>(a.size());
}

TEST(RateDistortion, WithoutARateWeightIsToTheNearest) {
  const auto values = laplacian(1000, 3);
  for (const bool predicted : {false, true}) {
    const auto back = restored(quantize_cheaply(values, predicted, {}), predicted);
    for (std::size_t i = 0; i < values.size(); ++i)
      ASSERT_LE(std::abs(back[i] - values[i]), 0.5 + 1e-12);
  }
}

TEST(RateDistortion, IsOffByOneAndAHalfAtMost) {
  const auto values = laplacian(5000, 3);
  for (const bool predicted : {false, true}) {
    const auto back =
        restored(quantize_cheaply(values, predicted, {.rate_weight = 100}), predicted);
    for (std::size_t i = 0; i < values.size(); ++i)
      ASSERT_LE(std::abs(back[i] - values[i]), 1.5 + 1e-12);
  }
}

// The point of it: at equal bits the error is smaller than that of coarser steps.
TEST(RateDistortion, BeatsACoarserStep) {
  const auto values = laplacian(50000, 0.6);
  const auto cheap = quantize_cheaply(values, false, {.rate_weight = 0.115});
  const double bits = entropy_bits(cheap), error = mean_square(values, restored(cheap, false));
  double step = 1, coarse_error = 0;
  for (;; step *= 1.005) {
    std::vector<double> coarse(values);
    for (double& v : coarse) v /= step;
    const auto numbers = quantize_cheaply(coarse, false, {});
    if (entropy_bits(numbers) > bits) continue;
    coarse_error = step * step * mean_square(coarse, restored(numbers, false));
    break;
  }
  EXPECT_LT(error, 0.97 * coarse_error);
}

TEST(RateDistortion, WeightsMoveTheErrorToWhereItCountsLess) {
  const auto values = laplacian(20000, 0.8);
  std::vector<float> weights(values.size());
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = i % 2 == 0 ? 1.9f : 0.1f;
  const auto back =
      restored(quantize_cheaply(values, false, {.rate_weight = 0.2, .weights = weights}), false);
  double heavy = 0, light = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    (i % 2 == 0 ? heavy : light) += (back[i] - values[i]) * (back[i] - values[i]);
  EXPECT_LT(heavy, 0.6 * light);
}

TEST(RateDistortion, LargeAndFewValues) {
  EXPECT_TRUE(quantize_cheaply({}, true, {.rate_weight = 1}).empty());
  const std::vector<double> values{2.6e8, -2.6e8, 0.4, 2.6e8};
  const auto back = restored(quantize_cheaply(values, true, {.rate_weight = 1}), true);
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_LE(std::abs(back[i] - values[i]), 1.5);
}

}  // namespace
}  // namespace fluxgs::codec
