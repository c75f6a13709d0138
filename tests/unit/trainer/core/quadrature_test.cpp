// Quadrature rules on the sphere.
#include "trainer/core/quadrature.h"

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

namespace fluxgs {
namespace {

double double_factorial(int n) { return n <= 1 ? 1 : n * double_factorial(n - 2); }

/// The mean of xⁱyʲzᵏ over the sphere.
double monomial_mean(int i, int j, int k) {
  if (i % 2 || j % 2 || k % 2) return 0;
  return double_factorial(i - 1) * double_factorial(j - 1) * double_factorial(k - 1) /
         double_factorial(i + j + k + 1);
}

double monomial_mean(const SphereRule& rule, int i, int j, int k) {
  double sum = 0;
  for (std::size_t n = 0; n < rule.weights.size(); ++n) {
    const glm::dvec3& d = rule.directions[n];
    sum += rule.weights[n] * std::pow(d.x, i) * std::pow(d.y, j) * std::pow(d.z, k);
  }
  return sum;
}

/// The largest error over all monomials of exactly this degree.
double error_at_degree(const SphereRule& rule, int degree) {
  double worst = 0;
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; i + j <= degree; ++j) {
      const int k = degree - i - j;
      worst = std::max(worst, std::abs(monomial_mean(rule, i, j, k) - monomial_mean(i, j, k)));
    }
  return worst;
}

void expect_unit_directions_and_weights(const SphereRule& rule, std::size_t samples) {
  ASSERT_EQ(rule.directions.size(), samples);
  ASSERT_EQ(rule.weights.size(), samples);
  double sum = 0;
  for (std::size_t n = 0; n < samples; ++n) {
    EXPECT_NEAR(glm::length(rule.directions[n]), 1, 1e-15);
    EXPECT_GT(rule.weights[n], 0);
    sum += rule.weights[n];
  }
  EXPECT_NEAR(sum, 1, 1e-11);  // rounding of many terms
}

TEST(Quadrature, LebedevRulesAreExactToTheirDegreeAndNoFurther) {
  const struct {
    int samples, degree;
  } rules[] = {{6, 3},    {14, 5},   {26, 7},   {38, 9},   {50, 11}, {86, 15},
               {110, 17}, {146, 19}, {170, 21}, {194, 23}, {302, 29}};
  for (const auto& [samples, degree] : rules) {
    const auto rule = sphere_rule(Quadrature::lebedev, samples, 1);
    ASSERT_TRUE(rule);
    expect_unit_directions_and_weights(*rule, static_cast<std::size_t>(samples));
    for (int d = 0; d <= degree; ++d)
      EXPECT_LT(error_at_degree(*rule, d), 1e-14) << samples << " directions, degree " << d;
    EXPECT_GT(error_at_degree(*rule, degree + 1), 1e-12) << samples;
  }
}

TEST(Quadrature, LebedevTakesTheNextRule) {
  for (const auto& [asked, got] : {std::pair{1, 6}, {7, 14}, {51, 86}, {128, 146}, {302, 302}})
    EXPECT_EQ(sphere_rule(Quadrature::lebedev, asked, 1)->weights.size(),
              static_cast<std::size_t>(got));
}

TEST(Quadrature, FibonacciCoversTheSphereEvenly) {
  for (const int samples : {1, 2, 64, 1000}) {
    const auto rule = sphere_rule(Quadrature::fibonacci, samples, 1);
    ASSERT_TRUE(rule);
    expect_unit_directions_and_weights(*rule, static_cast<std::size_t>(samples));
  }
  const auto rule = sphere_rule(Quadrature::fibonacci, 1000, 1);
  for (int degree = 1; degree <= 6; ++degree) EXPECT_LT(error_at_degree(*rule, degree), 1e-3);
}

TEST(Quadrature, MonteCarloIsUniformAndFollowsItsSeed) {
  const int samples = 20'000;
  const auto rule = sphere_rule(Quadrature::mc, samples, 5);
  ASSERT_TRUE(rule);
  expect_unit_directions_and_weights(*rule, samples);
  for (int degree = 1; degree <= 6; ++degree) {
    EXPECT_LT(error_at_degree(*rule, degree), 0.02);
    EXPECT_GT(error_at_degree(*rule, degree), 1e-5);
  }
  EXPECT_EQ(sphere_rule(Quadrature::mc, 10, 5)->directions,
            sphere_rule(Quadrature::mc, 10, 5)->directions);
  EXPECT_NE(sphere_rule(Quadrature::mc, 10, 5)->directions,
            sphere_rule(Quadrature::mc, 10, 6)->directions);
}

TEST(Quadrature, SaysWhatItCannotDo) {
  for (const auto& [quadrature, samples] : {std::pair{Quadrature::fibonacci, 0},
                                            {Quadrature::mc, -5},
                                            {Quadrature::lebedev, 303},
                                            {Quadrature::mc, kMaxSphereSamples + 1}})
    EXPECT_FALSE(sphere_rule(quadrature, samples, 1));
  EXPECT_EQ(sphere_rule(Quadrature::lebedev, 2048, 1).error().message(),
            "--samples: 2048 is out of range, expected 1 to 302 for --quadrature lebedev");
}

}  // namespace
}  // namespace fluxgs
