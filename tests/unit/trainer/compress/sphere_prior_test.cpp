// How much the sphere counts beside the views.
#include "trainer/compress/sphere_prior.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <limits>

#include "trainer/compress/adaptive_degree.h"
#include "unit/trainer/random_splats.h"

namespace fluxgs {
namespace {

constexpr std::size_t kCount = 300;

/// Bands of SH coefficients get smaller with the degree, as those of trained scenes do.
PlanarFloats smooth_sh() {
  PlanarFloats p = test::random_sh(kCount, 8);
  for (int r = row::sh_rest; r < p.rows(); ++r) {
    const int function = 1 + (r - row::sh_rest) / 3;
    const float degree = function < 4 ? 1 : function < 9 ? 2 : 3;
    for (std::size_t i = 0; i < kCount; ++i) p.row(r)[i] /= degree * degree;
  }
  return p;
}

ViewWeights cone_of_views(int count, double half_angle, Random& random) {
  std::vector<glm::dvec3> directions;
  for (int v = 0; v < count; ++v)
    directions.push_back(test::in_cone(test::degrees(half_angle), random));
  return test::views_along(directions, kCount, random);
}

/// By the definition: each view is taken away in turn, and all others are fitted to anew.
double refitted(const PlanarFloats& p, const ViewWeights& views, std::size_t i, int degree,
                double prior) {
  const ShCoefficients c = sh_coefficients(p, i);
  const SplatViews all = splat_views(views, p, i);
  double sum = 0;
  for (int v = 0; v < views.weights.rows(); ++v) {
    ViewWeights without = views;
    without.weights.row(v)[i] = 0;
    SplatViews rest = splat_views(without, p, i);
    // Of the same whole, so that the prior counts as much as before
    rest.gram *= rest.weight / all.weight;
    ViewWeights alone = views;
    for (int u = 0; u < views.weights.rows(); ++u)
      if (u != v) alone.weights.row(u)[i] = 0;
    const double part = double{views.weights.row(v)[i]} / all.weight;
    sum += part * square_error(splat_views(alone, p, i), c, fit_degree(rest, c, degree, prior));
  }
  return sum;
}

TEST(SpherePrior, LeavesEachViewOutOnce) {
  Random random(2);
  const PlanarFloats p = test::random_sh(kCount, 3);
  for (const int count : {1, 2, 7, 30}) {
    const ViewWeights views = cone_of_views(count, 50, random);
    for (const double prior : kSpherePriors) {
      double all_degrees = 0;
      for (std::size_t i = 0; i < 10; ++i) {
        const auto directions = directions_of(views, p, i);
        ASSERT_EQ(directions.size(), static_cast<std::size_t>(count));
        for (const int degree : {0, 1, 2, 3}) {
          const double expected = refitted(p, views, i, degree, prior);
          const double found = left_out_error(splat_views(views, p, i), directions,
                                              sh_coefficients(p, i), degree, prior);
          EXPECT_NEAR(found, expected, 1e-6 * expected + 1e-12);
          all_degrees += found * splat_views(views, p, i).weight;
        }
      }
      ViewWeights ten = views;
      for (int v = 0; v < count; ++v) std::fill_n(ten.weights.row(v) + 10, kCount - 10, 0.0f);
      EXPECT_NEAR(left_out_loss(p, ten, prior, Threads(2)) / all_degrees, 1, 1e-6);
    }
  }
}

/// Square errors of a view when degrees are adapted to `views`: of one of these, and of others.
glm::dvec2 losses_of(const PlanarFloats& p, const ViewWeights& views, const ViewWeights& others,
                     double prior) {
  const Unexplained u = unexplained_variance(p, views, prior, Threads(1));
  const auto degrees = min_degrees(u, threshold_for(u, views.pixels, 1e-4));
  const PlanarFloats fitted = fit_to_views(p, degrees, views, prior, Threads(1));
  glm::dvec2 losses(0);
  for (std::size_t i = 0; i < kCount; ++i)
    losses += glm::dvec2(test::square_loss(views, p, fitted, i) / views.weights.rows(),
                         test::square_loss(others, p, fitted, i) / others.weights.rows());
  return losses;
}

// Fitted to a few views only, colours elsewhere may become anything; many views say enough.
TEST(SpherePrior, IsLargeWhereViewsAreFew) {
  const PlanarFloats p = smooth_sh();
  Random random(9);
  const ViewWeights few = cone_of_views(6, 40, random), many = cone_of_views(100, 40, random);
  EXPECT_EQ(best_sphere_prior(p, many, Threads(1)), kSpherePrior);
  const double chosen = best_sphere_prior(p, few, Threads(1));
  EXPECT_GT(chosen, kSpherePrior);
  EXPECT_EQ(best_sphere_prior(p, few, Threads(2)), chosen);

  const glm::dvec2 least = losses_of(p, few, many, kSpherePrior),
                   best = losses_of(p, few, many, chosen);
  std::printf("prior %g: a view fitted to loses %.4f, another %.4f; prior %g: %.4f, %.4f\n",
              kSpherePrior, least.x, least.y, chosen, best.x, best.y);
  EXPECT_NEAR(best.x / least.x, 1, 0.05);
  EXPECT_LT(best.y, 0.85 * least.y);
}

TEST(SpherePrior, IsTheLeastWhereViewsSayNothing) {
  PlanarFloats p = test::random_sh(kCount, 3);
  const ViewWeights none{.weights = PlanarFloats(0, kCount)};
  EXPECT_EQ(left_out_loss(p, none, 0.1, Threads(1)), 0);
  EXPECT_EQ(best_sphere_prior(p, none, Threads(1)), kSpherePrior);
  EXPECT_EQ(best_sphere_prior(PlanarFloats(row::count(3), 0), none, Threads(1)), kSpherePrior);
  Random random(4);
  const ViewWeights views = cone_of_views(3, 30, random);
  for (std::size_t i = 0; i < kCount; ++i)
    p.row(row::sh_rest)[i] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(best_sphere_prior(p, views, Threads(1)), kSpherePrior);
}

}  // namespace
}  // namespace fluxgs
