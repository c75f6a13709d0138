// The formulas that everything else builds on: quaternions, spherical harmonics, projection.
#include <cmath>
#include <limits>
#include <numbers>

#include "fluxgs/math/projection.h"
#include "fluxgs/math/spherical_harmonics.h"
#include "support.h"

namespace fluxgs::math {
namespace {

template <class T>
T length(const Quat<T>& q) {
  return std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
}

TEST(Quaternion, NormalisesWhateverItsLength) {
  for (const float scale : {1.0f, 1e-30f, 1e-38f, 1e30f, 3e37f, 0.7f}) {
    const Quat<float> q = normalized(Quat<float>{1 * scale, -2 * scale, 3 * scale, 4 * scale});
    EXPECT_NEAR(length(q), 1, 2e-7) << scale;
    EXPECT_NEAR(q.w, 1 / std::sqrt(30.0), 2e-7) << scale;
    EXPECT_NEAR(q.z, 4 / std::sqrt(30.0), 2e-7) << scale;
  }
}

TEST(Quaternion, ZeroBecomesTheIdentity) {
  const Quat<float> q = normalized(Quat<float>{0, 0, 0, 0});
  EXPECT_EQ(q.w, 1);
  EXPECT_EQ(q.x, 0);
  EXPECT_EQ(q.y, 0);
  EXPECT_EQ(q.z, 0);
}

TEST(Quaternion, QuarterTurnAboutZTakesXToY) {
  const double h = std::sqrt(0.5);
  const Vec3<double> v = rotation_matrix(Quat<double>{h, 0, 0, h}) * Vec3<double>{1, 0, 0};
  EXPECT_NEAR(v.x, 0, 1e-15);
  EXPECT_NEAR(v.y, 1, 1e-15);
  EXPECT_NEAR(v.z, 0, 1e-15);
}

std::array<double, 16> all_basis(const Vec3<double>& d) {
  std::array<double, 16> basis{kSh0};
  sh_basis(3, d, basis.data() + 1);
  return basis;
}

TEST(SphericalHarmonics, BasisIsOrthonormal) {
  // Midpoints along z weigh alike (Archimedes); 2,000 × 16 directions.
  std::array<std::array<double, 16>, 16> gram{};
  const int along = 2000, around = 16;
  for (int i = 0; i < along; ++i) {
    const double z = (2 * i + 1.0) / along - 1, radius = std::sqrt(1 - z * z);
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * std::numbers::pi * k / around;
      const auto y = all_basis({radius * std::cos(angle), radius * std::sin(angle), z});
      for (std::size_t a = 0; a < 16; ++a) {
        for (std::size_t b = 0; b < 16; ++b) {
          gram[a][b] += y[a] * y[b] * 4 * std::numbers::pi / (along * around);
        }
      }
    }
  }
  for (std::size_t a = 0; a < 16; ++a) {
    for (std::size_t b = 0; b < 16; ++b) EXPECT_NEAR(gram[a][b], a == b, 1e-5) << a << ' ' << b;
  }
}

TEST(SphericalHarmonics, GradientMatchesCentralDifferences) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  double worst = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3<double> d{normal(random), normal(random), normal(random)};
    std::array<Vec3<double>, 15> gradient{};
    sh_basis_gradient(3, d, gradient.data());
    const double h = 1e-5;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3<double> step{axis == 0 ? h : 0, axis == 1 ? h : 0, axis == 2 ? h : 0};
      const auto above = all_basis(d + step), below = all_basis(d - step);
      for (std::size_t k = 0; k < 15; ++k) {
        const Vec3<double>& g = gradient[k];
        const double analytic = axis == 0 ? g.x : axis == 1 ? g.y : g.z;
        worst = std::max(worst, std::abs(analytic - (above[k + 1] - below[k + 1]) / (2 * h)));
      }
    }
  }
  EXPECT_LT(worst, 1e-8);
}

TEST(SphericalHarmonics, LowerDegreesWriteNoMoreThanTheirShare) {
  for (const int degree : {0, 1, 2, 3}) {
    std::array<double, 15> basis;
    basis.fill(7);
    sh_basis(degree, Vec3<double>{0.6, 0, 0.8}, basis.data());
    for (std::size_t k = static_cast<std::size_t>(sh_rest_count(degree)); k < 15; ++k) {
      EXPECT_EQ(basis[k], 7);
    }
  }
}

Camera simple_camera() {
  Camera camera;
  camera.width = 200;
  camera.height = 100;
  camera.fx = 120;
  camera.fy = 110;
  camera.cx = 100;
  camera.cy = 50;
  return camera;
}

TEST(Projection, CameraCentreAndDirection) {
  Camera camera = simple_camera();
  // Looking along +x: the rows of R are right = −z… chosen so that z of the camera is x of the
  // world.
  camera.rotation = glm::transpose(glm::dmat3(0, 0, -1, 0, 1, 0, 1, 0, 0));
  camera.translation = {1, 2, 3};
  EXPECT_EQ(camera.forward(), glm::dvec3(1, 0, 0));
  const glm::dvec3 back = camera.rotation * camera.center() + camera.translation;
  EXPECT_NEAR(glm::length(back), 0, 1e-15);
  const View<double> view = make_view<double>(camera, {});
  const Vec3<double> p = view.rotation * Vec3<double>{5, 0, 0} + view.translation;
  EXPECT_NEAR(p.z, 8, 1e-15);  // 5 along the direction of view, plus t
}

// A point 2 away, 0.5 right and 0.25 down: on the screen at (100 + 120/4, 50 + 110/8), and the
// Jacobian by hand: fx/z = 60, −fx·x/z² = −15, fy/z = 55, −fy·y/z² = −6.875.
TEST(Projection, JacobianOfAPointByHand) {
  const View<double> view = make_view<double>(simple_camera(), {});
  const Vec3<double> p{0.5, 0.25, 2};
  EXPECT_NEAR(view.fx * p.x / p.z + view.cx, 130, 1e-12);
  EXPECT_NEAR(view.fy * p.y / p.z + view.cy, 63.75, 1e-12);
  const Jacobian<double> j = projection_jacobian(p, view);
  EXPECT_NEAR(j.x0, 60, 1e-12);
  EXPECT_NEAR(j.x2, -15, 1e-12);
  EXPECT_NEAR(j.y1, 55, 1e-12);
  EXPECT_NEAR(j.y2, -6.875, 1e-12);
}

TEST(Projection, JacobianIsLimitedBesideTheImage) {
  const View<double> view = make_view<double>(simple_camera(), {});
  const Jacobian<double> j = projection_jacobian(Vec3<double>{100, -100, 1}, view);
  EXPECT_NEAR(j.slope_x, (200 * 1.15 - 100) / 120, 1e-12);
  EXPECT_NEAR(j.slope_y, (-0.15 * 100 - 50) / 110, 1e-12);
}

}  // namespace
}  // namespace fluxgs::math
