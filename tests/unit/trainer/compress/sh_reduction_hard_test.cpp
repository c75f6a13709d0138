// Views that say too little, and numbers that are none.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "trainer/compress/adaptive_degree.h"
#include "trainer/compress/fit_splats.h"
#include "unit/trainer/random_splats.h"

namespace fluxgs {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr std::size_t kSplats = 40;

using Directions = std::vector<glm::dvec3>;

ViewWeights views_along(const Directions& directions) {
  Random random(9);
  return test::views_along(directions, kSplats, random);
}

PlanarFloats fit(const PlanarFloats& p, const ViewWeights& views, int degree = 1) {
  return fit_to_views(p, degree, views, kSpherePrior, Threads(1));
}

void expect_same(const PlanarFloats& a, const PlanarFloats& b, double tolerance) {
  ASSERT_EQ(a.rows(), b.rows());
  for (int r = 0; r < a.rows(); ++r)
    for (std::size_t i = 0; i < a.size(); ++i)
      ASSERT_NEAR(a.row(r)[i], b.row(r)[i], tolerance) << "row " << r << ", splat " << i;
}

/// The coefficients of `after` less those of `before`, zero where it has none.
Eigen::MatrixXd change(const PlanarFloats& before, const PlanarFloats& after, std::size_t i) {
  Eigen::MatrixXd delta(sh_rest_count(sh_degree_of(after)) + 1, 3);
  for (int r = row::sh_dc; r < after.rows(); ++r)
    delta((r - row::sh_dc) / 3, (r - row::sh_dc) % 3) =
        double{after.row(r)[i]} - double{before.row(r)[i]};
  return delta;
}

double largest_change(const PlanarFloats& before, const PlanarFloats& after) {
  double largest = 0;
  for (std::size_t i = 0; i < before.size(); ++i)
    largest = std::max(largest, change(before, after, i).cwiseAbs().maxCoeff());
  return largest;
}

glm::dvec3 dropped_at(const PlanarFloats& p, const PlanarFloats& fitted, std::size_t i,
                      const glm::dvec3& d) {
  return test::color_at(p, i, d) - test::color_at(fitted, i, d);
}

TEST(ShReductionHardCases, SeenByNoCameraIsTruncated) {
  const PlanarFloats p = test::random_sh(kSplats, 1);
  expect_same(fit(p, ViewWeights{.weights = PlanarFloats(0, kSplats)}), rows_of_degree(p, 1), 0);
  ViewWeights views = views_along({{0, 0, 1}, {0, 1, 0}});
  for (int v = 0; v < 2; ++v) std::fill_n(views.weights.row(v), kSplats, 0.0f);
  expect_same(fit(p, views), rows_of_degree(p, 1), 0);
  const Unexplained u = unexplained_variance(p, views, kSpherePrior, Threads(1));
  EXPECT_EQ(u.weights[0], 0);
  EXPECT_EQ(u.fitted.row(0)[0], 0);
}

// The smallest change that keeps the colour in the one view: along the basis functions there.
TEST(ShReductionHardCases, SeenByOneCameraKeepsItsColourThere) {
  const PlanarFloats p = test::random_sh(kSplats, 2);
  const glm::dvec3 d = glm::normalize(glm::dvec3(1, -2, 3));
  const PlanarFloats cut = rows_of_degree(p, 1), fitted = fit(p, views_along({d}));
  double y[4] = {math::kSh0};
  math::sh_basis(1, math::Vec3<double>{d.x, d.y, d.z}, y + 1);
  for (std::size_t i = 0; i < kSplats; ++i) {
    const glm::dvec3 before = dropped_at(p, cut, i, d), after = dropped_at(p, fitted, i, d);
    const Eigen::MatrixXd delta = change(p, fitted, i);
    for (int c = 0; c < 3; ++c) {
      EXPECT_LE(std::abs(after[c]), 1.1 * kSpherePrior / 4 * std::abs(before[c]) + 1e-6);
      for (int j = 0; j < 4; ++j)
        EXPECT_NEAR(delta(j, c), (before[c] - after[c]) * y[j] * std::numbers::pi, 1e-5);
    }
  }
}

TEST(ShReductionHardCases, IdenticalCamerasAreOneCamera) {
  const PlanarFloats p = test::random_sh(kSplats, 3);
  const glm::dvec3 d = glm::normalize(glm::dvec3(2, 1, 1));
  expect_same(fit(p, views_along(Directions(50, d))), fit(p, views_along({d})), 1e-5);
}

TEST(ShReductionHardCases, TwoCamerasAndALineOfCamerasKeepColoursThereAndStaySmall) {
  const PlanarFloats p = test::random_sh(kSplats, 4);
  Directions line;  // coplanar directions, over 60°
  for (int v = 0; v < 30; ++v) line.push_back({std::sin(v * 0.035), 0, std::cos(v * 0.035)});
  for (const Directions& directions : {Directions{line.front(), line.back()}, line}) {
    const ViewWeights views = views_along(directions);
    const PlanarFloats cut = rows_of_degree(p, 1), fitted = fit(p, views);
    double before = 0, after = 0;
    for (std::size_t i = 0; i < kSplats; ++i) {
      before += test::square_loss(views, p, cut, i);
      after += test::square_loss(views, p, fitted, i);
      // What no camera of the line can tell apart stays: −y, the second function
      EXPECT_NEAR(change(p, fitted, i).row(1).cwiseAbs().maxCoeff(), 0, 1e-5);
    }
    EXPECT_LT(after, 0.1 * before);
    EXPECT_LT(largest_change(p, fitted), 40);
  }
}

// The bound of sh_fit.h, and no jumps: cameras that move a little change the colours a little.
TEST(ShReductionHardCases, IsBoundedAndSmoothForAnyNumberOfCamerasInANarrowCone) {
  const PlanarFloats p = test::random_sh(kSplats, 5);
  Random random(6);
  for (const int degree : {0, 1, 2})
    for (const double half_angle : {0., 1e-6, 1e-3, 0.03, 0.3})
      for (const int cameras : {1, 2, 3, 4, 9, 50}) {
        Directions directions, moved;
        for (int v = 0; v < cameras; ++v) {
          directions.push_back(test::in_cone(half_angle, random));
          moved.push_back(glm::normalize(directions.back() + 1e-6 * test::in_cone(3, random)));
        }
        const ViewWeights views = views_along(directions);
        const PlanarFloats fitted = fit(p, views, degree), cut = rows_of_degree(p, degree);
        for (std::size_t i = 0; i < kSplats; ++i) {
          const double over_sphere = change(p, fitted, i).norm() / std::sqrt(4 * std::numbers::pi);
          double weight = 0;
          for (int v = 0; v < cameras; ++v) weight += double{views.weights.row(v)[i]};
          const double over_views = std::sqrt(test::square_loss(views, p, cut, i) / weight);
          ASSERT_LE(over_sphere, (1 + 1e-4) / (2 * std::sqrt(kSpherePrior)) * over_views + 1e-5);
        }
        expect_same(fitted, fit(p, views_along(moved), degree), 2e-3);
      }
}

TEST(ShReductionHardCases, TheScaleOfTheWeightsDoesNotMatter) {
  const PlanarFloats p = test::random_sh(kSplats, 6);
  Random random(7);
  Directions directions;
  for (int v = 0; v < 6; ++v) directions.push_back(test::in_cone(0.4, random));
  ViewWeights views = views_along(directions);
  const PlanarFloats expected = fit(p, views);
  for (const float scale : {1e-30f, 1e6f}) {
    ViewWeights scaled = views;
    for (int v = 0; v < 6; ++v)
      for (std::size_t i = 0; i < kSplats; ++i) scaled.weights.row(v)[i] *= scale;
    expect_same(fit(p, scaled), expected, 1e-5);
  }
}

TEST(ShReductionHardCases, ViewsThatAreNoneDoNotCount) {
  const PlanarFloats p = test::random_sh(kSplats, 7);
  const Directions directions{{0, 0, 1}, {0.6, 0, 0.8}, {0, 0.6, 0.8}};
  ViewWeights views = views_along(directions);
  const PlanarFloats expected = fit(p, views);
  views.weights = PlanarFloats(7, kSplats);
  for (int v = 0; v < 3; ++v)
    std::copy_n(views_along(directions).weights.row(v), kSplats, views.weights.row(v));
  for (const float bad : {kNaN, kInfinity, -1.0f, 1.0f}) {
    std::fill_n(views.weights.row(static_cast<int>(views.centers.size())), kSplats, bad);
    views.centers.emplace_back(1, 2, 3);
  }
  views.centers.back() = glm::dvec3(0);  // where the splats are
  expect_same(fit(p, views), expected, 0);
}

TEST(ShReductionHardCases, NumbersThatAreNoneStayNone) {
  const PlanarFloats clean = test::random_sh(kSplats, 8);
  PlanarFloats p = clean;
  p.row(row::sh_rest + 40)[0] = kNaN;
  p.row(row::sh_dc)[1] = kInfinity;
  p.row(row::position)[2] = kNaN;
  p.row(row::position)[3] = kInfinity;
  for (int r = row::sh_dc; r < p.rows(); ++r) p.row(r)[4] = r % 2 ? 3e38f : -3e38f;
  p.row(row::position)[5] = 3e38f;
  Random random(7);
  Directions directions;
  for (int v = 0; v < 6; ++v) directions.push_back(test::in_cone(0.4, random));
  const ViewWeights views = views_along(directions);
  const PlanarFloats fitted = fit(p, views), cut = rows_of_degree(p, 1);
  for (const std::size_t i : {0, 1}) EXPECT_TRUE(std::isnan(fitted.row(row::sh_dc)[i]));
  for (const std::size_t i : {2, 3})  // not seen
    for (int r = row::sh_dc; r < fitted.rows(); ++r) EXPECT_EQ(fitted.row(r)[i], cut.row(r)[i]);
  for (const std::size_t i : {4, 5})
    for (int r = row::sh_dc; r < fitted.rows(); ++r) EXPECT_TRUE(std::isfinite(fitted.row(r)[i]));
  const PlanarFloats expected = fit(clean, views);
  for (std::size_t i = 6; i < kSplats; ++i)
    for (int r = 0; r < fitted.rows(); ++r) EXPECT_EQ(fitted.row(r)[i], expected.row(r)[i]);

  const Unexplained u = unexplained_variance(p, views, kSpherePrior, Threads(1));
  for (int d = 0; d < 4; ++d)
    for (std::size_t i = 0; i < kSplats; ++i) {
      EXPECT_TRUE(std::isfinite(u.fitted.row(d)[i]));
      EXPECT_TRUE(std::isfinite(u.truncated.row(d)[i]));
    }
  EXPECT_EQ(min_degrees(u, 0)[0], 0);  // nothing to lose
  EXPECT_GE(threshold_for(u, views.pixels, 1e-3), 0);
}

TEST(ShReductionHardCases, NoSplatsAtAll) {
  const PlanarFloats none(row::count(3), 0);
  const ViewWeights views{.centers = {{0, 0, 0}}, .weights = PlanarFloats(1, 0), .pixels = 1};
  EXPECT_EQ(fit(none, views).size(), 0u);
  EXPECT_EQ(threshold_for(unexplained_variance(none, views, kSpherePrior, Threads(1)), 1, 1), 0);
}

}  // namespace
}  // namespace fluxgs
