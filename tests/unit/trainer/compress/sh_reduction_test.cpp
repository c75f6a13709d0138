// Lower degrees by least squares over the views (fact 3).
#include "trainer/compress/fit_splats.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <Eigen/QR>

#include "unit/trainer/random_splats.h"

namespace fluxgs {
namespace {

/// Rows of degree 3 again, the missing ones zero.
PlanarFloats padded(const PlanarFloats& p) {
  PlanarFloats result(row::count(3), p.size());
  for (int r = 0; r < p.rows(); ++r) std::copy_n(p.row(r), p.size(), result.row(r));
  return result;
}

void expect_same_rows(const PlanarFloats& a, const PlanarFloats& b, double tolerance) {
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_EQ(a.size(), b.size());
  for (int r = 0; r < a.rows(); ++r)
    for (std::size_t i = 0; i < a.size(); ++i)
      ASSERT_NEAR(a.row(r)[i], b.row(r)[i], tolerance) << "row " << r << ", splat " << i;
}

/// The definition, solved as one tall least-squares problem: a row for each view, and rows for the
/// sphere, by a quadrature that is exact for the squares of all SH coefficients.
Eigen::MatrixXd tall_solution(const PlanarFloats& p, const ViewWeights& views, std::size_t i,
                              int degree, double prior) {
  const SphereRule sphere = *sphere_rule(Quadrature::lebedev, 26, 1);
  double total = 0;
  for (int v = 0; v < views.weights.rows(); ++v) total += double{views.weights.row(v)[i]};
  const auto seen = static_cast<std::size_t>(views.weights.rows());
  const auto rows = static_cast<Eigen::Index>(seen + sphere.weights.size());
  const int n = (degree + 1) * (degree + 1);
  Eigen::MatrixXd a(rows, n), b(rows, 3);
  for (std::size_t k = 0; k < seen + sphere.weights.size(); ++k) {
    const bool view = k < seen;
    const glm::dvec3 d = view ? glm::normalize(-views.centers[k]) : sphere.directions[k - seen];
    const double weight = view ? double{views.weights.row(static_cast<int>(k))[i]} / total
                               : prior * sphere.weights[k - seen];
    double basis[kShCount] = {math::kSh0};
    math::sh_basis(3, math::Vec3<double>{d.x, d.y, d.z}, basis + 1);
    const glm::dvec3 color = test::color_at(p, i, d);
    const auto at = static_cast<Eigen::Index>(k);
    for (int j = 0; j < n; ++j) a(at, j) = std::sqrt(weight) * basis[j];
    for (int c = 0; c < 3; ++c) b(at, c) = std::sqrt(weight) * color[c];
  }
  return a.colPivHouseholderQr().solve(b);
}

std::vector<glm::dvec3> cone(double half_angle, int count, Random& random) {
  std::vector<glm::dvec3> directions;
  for (int v = 0; v < count; ++v) directions.push_back(test::in_cone(half_angle, random));
  return directions;
}

TEST(ShReduction, SolvesTheLeastSquaresProblem) {
  Random random(3);
  const PlanarFloats p = test::random_sh(20, 1);
  const ViewWeights views = test::views_along(cone(test::degrees(50), 40, random), 20, random);
  for (const double prior : {1e-4, 1e-3, 0.3})
    for (const int degree : {0, 1, 2}) {
      const PlanarFloats fitted = fit_to_views(p, degree, views, prior, Threads(1));
      ASSERT_EQ(fitted.rows(), row::count(degree));
      for (std::size_t i = 0; i < p.size(); ++i) {
        const Eigen::MatrixXd expected = tall_solution(p, views, i, degree, prior);
        for (int r = row::sh_dc; r < fitted.rows(); ++r)
          EXPECT_NEAR(fitted.row(r)[i], expected((r - row::sh_dc) / 3, (r - row::sh_dc) % 3), 1e-5);
      }
    }
}

TEST(ShReduction, KeepsTheOtherRowsAndTruncatesAsAsked) {
  Random random(4);
  PlanarFloats p = test::random_sh(33, 2);
  for (int r = 0; r < row::sh_dc; ++r)
    for (std::size_t i = 0; i < p.size(); ++i) p.row(r)[i] = static_cast<float>(normal(random));
  const ViewWeights views = test::views_along(cone(1, 20, random), 33, random);
  const PlanarFloats fitted = fit_to_views(p, 1, views, kSpherePrior, Threads(1));
  const PlanarFloats cut = rows_of_degree(p, 1);
  EXPECT_EQ(cut.rows(), row::count(1));
  for (int r = 0; r < row::count(1); ++r)
    for (std::size_t i = 0; i < p.size(); ++i) {
      EXPECT_EQ(cut.row(r)[i], p.row(r)[i]);
      if (r < row::sh_dc) {
        EXPECT_EQ(fitted.row(r)[i], p.row(r)[i]);
      }
    }
}

// Over the whole sphere, least squares is truncation.
TEST(ShReduction, UniformLeastSquaresIsTruncation) {
  const PlanarFloats p = test::random_sh(100, 3);
  for (const int degree : {0, 1, 2}) {
    const PlanarFloats cut = rows_of_degree(p, degree);
    for (const int exact : {14, 26, 110})  // degree 5 at least
      expect_same_rows(
          fit_to_sphere(p, degree, *sphere_rule(Quadrature::lebedev, exact, 1), Threads(1)), cut,
          1e-6);
    const auto spiral = sphere_rule(Quadrature::fibonacci, 2048, 1);
    expect_same_rows(fit_to_sphere(p, degree, *spiral, Threads(1)), cut, 2e-3);
  }
}

TEST(ShReduction, IsTheSameForAnyNumberOfThreads) {
  Random random(5);
  const PlanarFloats p = test::random_sh(3000, 4);
  const ViewWeights views = test::views_along(cone(0.5, 12, random), p.size(), random);
  expect_same_rows(fit_to_views(p, 1, views, kSpherePrior, Threads(1)),
                   fit_to_views(p, 1, views, kSpherePrior, Threads(3)), 0);
}

TEST(ShReduction, ReportsWhatIsLeft) {
  Random random(6);
  const PlanarFloats p = test::random_sh(50, 5);
  const ViewWeights views = test::views_along(cone(0.8, 30, random), p.size(), random);
  const Unexplained u = unexplained_variance(p, views, kSpherePrior, Threads(1));
  for (const int degree : {0, 1, 2, 3}) {
    const PlanarFloats cut = padded(rows_of_degree(p, degree));
    const PlanarFloats fitted = padded(fit_to_views(p, degree, views, kSpherePrior, Threads(1)));
    for (std::size_t i = 0; i < p.size(); ++i) {
      const double weight = double{u.weights[i]};
      const double before = test::square_loss(views, p, cut, i) / weight;
      const double after = test::square_loss(views, p, fitted, i) / weight;
      EXPECT_NEAR(u.truncated.row(degree)[i], before, 1e-5 * before);
      EXPECT_NEAR(u.fitted.row(degree)[i], after, 1e-4 * after + 1e-9);
    }
  }
}

/// How many times more truncation leaves than the fit to `views`, seen from `judges`; sums over
/// all splats.
double gain(const PlanarFloats& p, int degree, const ViewWeights& views,
            const ViewWeights& judges) {
  const PlanarFloats cut = padded(rows_of_degree(p, degree));
  const PlanarFloats fitted = padded(fit_to_views(p, degree, views, kSpherePrior, Threads(1)));
  double before = 0, after = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    before += test::square_loss(judges, p, cut, i);
    after += test::square_loss(judges, p, fitted, i);
  }
  return before / after;
}

// Fact 3: where the views lie in a cone, the fit leaves less of the view-dependent colour than
// truncation, also in directions that it was not fitted to. (Random coefficients of equal size in
// all bands; 1.6 to 5.2 times to degree 1 are cones of about 80° to 47°.)
TEST(ShReduction, LeavesLessThanTruncationInACone) {
  const struct {
    double half_angle;
    double least, most;  // to degree 1
  } cones[] = {{30, 15, 27},   {45, 4.5, 7.5},   {60, 2.2, 3.5}, {75, 1.6, 2.1},
               {90, 1.3, 1.6}, {120, 1.1, 1.25}, {180, 1, 1.1}};
  const PlanarFloats p = test::random_sh(100, 6);
  std::printf("variance unexplained after truncation / after the fit\n");
  std::printf("half-angle  degree 0, 1, 2   in other directions\n");
  for (const auto& [half_angle, least, most] : cones) {
    Random random(7);
    const double angle = test::degrees(half_angle);
    const ViewWeights views = test::views_along(cone(angle, 100, random), p.size(), random);
    const ViewWeights others = test::views_along(cone(angle, 100, random), p.size(), random);
    double own[3], other[3];
    for (int d = 0; d < 3; ++d)
      own[d] = gain(p, d, views, views), other[d] = gain(p, d, views, others);
    std::printf("%9g°  %.2f %.2f %.2f    %.2f %.2f %.2f\n", half_angle, own[0], own[1], own[2],
                other[0], other[1], other[2]);
    EXPECT_GT(own[1], least);
    EXPECT_LT(own[1], most);
    for (int d = 0; d < 3; ++d) EXPECT_GT(own[d], 1);
    if (half_angle < 90) {
      EXPECT_GT(other[1], 0.6 * own[1]);
    }
  }
}

}  // namespace
}  // namespace fluxgs
