// The paper's energy moments, and what is wrong with them (facts 1 and 2).
#include "trainer/paper/energy_moments.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "unit/trainer/random_splats.h"

namespace fluxgs {
namespace {

using Moments = std::array<double, 12>;

/// Bands that the residual leaves out become zero.
PlanarFloats residual_of(PlanarFloats p, Residual residual) {
  const int below = residual == Residual::from_0 ? 0 : residual == Residual::from_1 ? 1 : 2;
  for (int r = row::sh_dc; r < std::min(p.rows(), row::count(below)); ++r)
    for (std::size_t i = 0; i < p.size(); ++i) p.row(r)[i] = 0;
  return p;
}

/// The definition, in float64.
Moments reference(const PlanarFloats& residual, std::size_t i, const SphereRule& rule) {
  Moments m{};
  for (std::size_t k = 0; k < rule.weights.size(); ++k) {
    const glm::dvec3& d = rule.directions[k];
    const glm::dvec3 f = glm::max(test::color_at(residual, i, d), glm::dvec3(0)) * rule.weights[k];
    for (int c = 0; c < 3; ++c) {
      m[static_cast<std::size_t>(c)] += f[c];
      for (int axis = 0; axis < 3; ++axis)
        m[static_cast<std::size_t>(3 * (axis + 1) + c)] += d[axis] * f[c];
    }
  }
  return m;
}

/// Root mean squares over splats and channels.
struct Rms {
  double mag = 0, dir = 0;
};

Rms rms(const std::vector<Moments>& moments) {
  Rms sum;
  for (const Moments& m : moments)
    for (std::size_t j = 0; j < 12; ++j) (j < 3 ? sum.mag : sum.dir) += m[j] * m[j];
  const double count = static_cast<double>(moments.size());
  return {std::sqrt(sum.mag / (3 * count)), std::sqrt(sum.dir / (9 * count))};
}

std::vector<Moments> columns(const PlanarFloats& energy) {
  std::vector<Moments> result(energy.size());
  for (std::size_t i = 0; i < energy.size(); ++i)
    for (std::size_t j = 0; j < 12; ++j) result[i][j] = double{energy.row(static_cast<int>(j))[i]};
  return result;
}

std::vector<Moments> less(std::vector<Moments> a, const std::vector<Moments>& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < 12; ++j) a[i][j] -= b[i][j];
  return a;
}

std::vector<Moments> references(const PlanarFloats& p, Residual residual, const SphereRule& rule) {
  const PlanarFloats bands = residual_of(p, residual);
  std::vector<Moments> result(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) result[i] = reference(bands, i, rule);
  return result;
}

SphereRule rule_of(Quadrature quadrature, int samples, std::uint64_t seed = 1) {
  return *sphere_rule(quadrature, samples, seed);
}

TEST(EnergyMoments, AreThoseOfTheDefinitionOnEveryInstructionSet) {
  const Threads threads(1);
  for (const int degree : {0, 1, 2, 3}) {
    const PlanarFloats p = test::random_sh(437, 3, degree);
    for (const Residual residual : {Residual::from_0, Residual::from_1, Residual::from_2})
      for (const Quadrature q : {Quadrature::fibonacci, Quadrature::lebedev, Quadrature::mc}) {
        const SphereRule rule = rule_of(q, 100);
        const auto expected = references(p, residual, rule);
        for (const Isa isa : available_isas()) {
          const PlanarFloats energy =
              energy_moments(p, residual, rule, threads, energy_kernels(isa));
          ASSERT_EQ(energy.rows(), 12);
          ASSERT_EQ(energy.size(), p.size());
          const auto got = columns(energy);
          for (std::size_t i = 0; i < p.size(); ++i)
            for (std::size_t j = 0; j < 12; ++j) ASSERT_NEAR(got[i][j], expected[i][j], 2e-6);
        }
      }
  }
}

TEST(EnergyMoments, AreTheSameForAnyNumberOfThreads) {
  const PlanarFloats p = test::random_sh(5000, 4);
  const SphereRule rule = rule_of(Quadrature::fibonacci, 64);
  const auto one = columns(energy_moments(p, Residual::from_1, rule, Threads(1)));
  EXPECT_EQ(one, columns(energy_moments(p, Residual::from_1, rule, Threads(3))));
}

TEST(EnergyMoments, AreFiniteWhateverTheCoefficientsAre) {
  const Threads threads(1);
  PlanarFloats p = test::random_sh(40, 5);
  const PlanarFloats before = p;
  p.row(row::sh_rest + 30)[3] = std::numeric_limits<float>::quiet_NaN();
  p.row(row::sh_rest + 31)[4] = std::numeric_limits<float>::infinity();
  for (int r = row::sh_rest; r < p.rows(); ++r) p.row(r)[5] = 3e38f;
  const SphereRule rule = rule_of(Quadrature::fibonacci, 64);
  const auto got = columns(energy_moments(p, Residual::from_1, rule, threads));
  const auto expected = columns(energy_moments(before, Residual::from_1, rule, threads));
  for (std::size_t i = 0; i < p.size(); ++i)
    for (std::size_t j = 0; j < 12; ++j) {
      EXPECT_TRUE(std::isfinite(got[i][j]));
      if (i < 3 || i > 5) {
        EXPECT_EQ(got[i][j], expected[i][j]);
      }
    }
  EXPECT_EQ(got[3][0], 0);
  EXPECT_EQ(got[4][1], 0);
  EXPECT_EQ(got[3][1], expected[3][1]);  // another channel
  EXPECT_TRUE(
      columns(energy_moments(PlanarFloats(row::count(3), 0), Residual::from_1, rule, threads))
          .empty());
}

// Fact 1: E_dir of the paper's residual is zero. Every rule that is its own mirror image and exact
// to degree 4 says so; Monte Carlo returns noise that falls as 1/√K.
TEST(EnergyMoments, DirectionOfThePapersResidualIsZero) {
  const Threads threads(1);
  const PlanarFloats p = test::random_sh(300, 7);
  for (const int samples : {14, 38, 110, 302}) {
    const SphereRule rule = rule_of(Quadrature::lebedev, samples);
    EXPECT_LT(rms(references(p, Residual::from_2, rule)).dir, 1e-15);
    const Rms of_2 = rms(columns(energy_moments(p, Residual::from_2, rule, threads)));
    EXPECT_LT(of_2.dir, 2e-7 * of_2.mag);
  }
  const Rms of_1 =
      rms(columns(energy_moments(p, Residual::from_1, rule_of(Quadrature::lebedev, 110), threads)));
  EXPECT_GT(of_1.dir, 0.05 * of_1.mag);

  const auto noise = [&](int samples) {
    double square = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const SphereRule rule = rule_of(Quadrature::mc, samples, seed);
      const double dir = rms(columns(energy_moments(p, Residual::from_2, rule, threads))).dir;
      square += dir * dir / 10;
    }
    return std::sqrt(square);
  };
  const double few = noise(128), many = noise(2048);
  std::printf(
      "E_dir of residual 3-2, Monte Carlo: %.2e (K=128), %.2e (K=2048), times √K %.3f %.3f\n", few,
      many, few * std::sqrt(128.0), many * std::sqrt(2048.0));
  EXPECT_NEAR(few / many, 4, 0.8);
}

/// Error of a rule relative to the moments' own root mean square; Monte Carlo: over 10 seeds.
Rms relative_error(const PlanarFloats& p, Residual residual, const std::vector<Moments>& exact,
                   Quadrature quadrature, int samples) {
  const int seeds = quadrature == Quadrature::mc ? 10 : 1;
  const Rms own = rms(exact);
  Rms sum;
  for (int seed = 1; seed <= seeds; ++seed) {
    const SphereRule rule = rule_of(quadrature, samples, static_cast<std::uint64_t>(seed));
    const Rms e = rms(less(columns(energy_moments(p, residual, rule, Threads(1))), exact));
    sum.mag += e.mag * e.mag / seeds;
    sum.dir += e.dir * e.dir / seeds;
  }
  return {std::sqrt(sum.mag) / own.mag, std::sqrt(sum.dir) / own.dir};
}

struct ExpectedError {
  Quadrature quadrature;
  int samples;
  double mag, dir;  // 0: not stated
};

// Fact 2: error against K for each rule, relative to the moments' own size, for random coefficients
// in bands 1 to 3. The exact values are those of a spiral of 50,000 directions in float64.
TEST(EnergyMoments, ErrorAgainstSamples) {
  constexpr ExpectedError table[] = {{Quadrature::mc, 64, .2, .6},
                                     {Quadrature::mc, 2048, .03, .1},
                                     {Quadrature::mc, 4096, .02, .07},
                                     {Quadrature::fibonacci, 64, .013, .036},
                                     {Quadrature::fibonacci, 128, .005, .014},
                                     {Quadrature::fibonacci, 256, .002, .006},
                                     {Quadrature::fibonacci, 2048, 1.4e-4, 4e-4},
                                     {Quadrature::lebedev, 38, .026, 0},
                                     {Quadrature::lebedev, 110, .006, 0},
                                     {Quadrature::lebedev, 302, 0, 0}};
  const PlanarFloats p = test::random_sh(50, 11);
  const SphereRule fine = rule_of(Quadrature::fibonacci, 50'000);
  const auto all = references(p, Residual::from_0, fine);
  const auto upper = references(p, Residual::from_1, fine);
  std::printf("%-9s %5s  residual 3-0: E_mag    E_dir   3-1: E_mag    E_dir\n", "rule", "K");
  for (const auto& [quadrature, samples, mag, dir] : table) {
    const Rms e = relative_error(p, Residual::from_0, all, quadrature, samples);
    const Rms u = relative_error(p, Residual::from_1, upper, quadrature, samples);
    std::printf("%-9s %5d  %19.2e %.2e %12.2e %.2e\n", name_of(quadrature).data(), samples, e.mag,
                e.dir, u.mag, u.dir);
    // Stated to one digit or two
    if (mag > 0) {
      EXPECT_NEAR(e.mag / mag, 1, 0.25);
    }
    if (dir > 0) {
      EXPECT_NEAR(e.dir / dir, 1, 0.25);
    }
    // E_dir of bands 2 and 3 is smaller, so the same noise weighs more
    EXPECT_NEAR(u.mag / e.mag, 1, 0.3);
    EXPECT_GT(u.dir, 1.5 * e.dir);
  }
}

}  // namespace
}  // namespace fluxgs
