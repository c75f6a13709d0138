#include "fluxgs/math/sh_rotation.h"

#include <cmath>

#include <glm/gtc/quaternion.hpp>

#include "fluxgs/math/projection.h"
#include "fluxgs/math/spherical_harmonics.h"
#include "fluxgs/splat_cloud.h"
#include "support.h"

namespace fluxgs::math {
namespace {

using Rng = std::mt19937;

Vec3<double> random_direction(Rng& random) {
  std::normal_distribution<double> normal;
  const glm::dvec3 d = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
  return {d.x, d.y, d.z};
}

Mat3<double> random_rotation(Rng& random) {
  std::normal_distribution<double> normal;
  return rotation_matrix(
      normalized(Quat<double>{normal(random), normal(random), normal(random), normal(random)}));
}

std::vector<glm::vec3> random_coefficients(Rng& random, int degree) {
  std::normal_distribution<float> normal;
  std::vector<glm::vec3> c(static_cast<std::size_t>(sh_rest_count(degree)));
  for (glm::vec3& v : c) v = {normal(random), normal(random), normal(random)};
  return c;
}

glm::dvec3 evaluate(int degree, const std::vector<glm::vec3>& c, const Vec3<double>& d) {
  std::array<double, 15> basis{};
  sh_basis(degree, d, basis.data());
  glm::dvec3 sum(0);
  for (std::size_t k = 0; k < c.size(); ++k) sum += basis[k] * glm::dvec3(c[k]);
  return sum;
}

TEST(ShRotation, TurnsTheFunctionOnTheSphere) {
  Rng random(5);
  double worst = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Mat3<double> r = random_rotation(random);
    const ShRotation rotation = make_sh_rotation(r);
    for (const int degree : {0, 1, 2, 3}) {
      const auto before = random_coefficients(random, degree);
      auto after = before;
      rotate_sh(rotation, degree, after.data());
      for (int k = 0; k < 10; ++k) {
        const Vec3<double> d = random_direction(random);
        const glm::dvec3 difference =
            evaluate(degree, after, d) - evaluate(degree, before, transpose_times(r, d));
        worst = std::max(worst, glm::length(difference));
      }
    }
  }
  RecordProperty("worst", std::to_string(worst));
  std::printf("worst |f'(d) - f(R^-1 d)|: %.2e\n", worst);
  EXPECT_LT(worst, 1e-5);
}

TEST(ShRotation, IdentityMatricesForTheIdentity) {
  const ShRotation rotation = make_sh_rotation({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  for (std::size_t i = 0; i < 7; ++i) {
    for (std::size_t k = 0; k < 7; ++k) {
      EXPECT_NEAR(rotation.degree3[i * 7 + k], i == k, 1e-14);
    }
  }
}

TEST(ShRotation, MatricesAreOrthogonalAndCompose) {
  Rng random(6);
  const Mat3<double> a = random_rotation(random), b = random_rotation(random);
  const Mat3<double> ab{transpose_times(b, a.row0), transpose_times(b, a.row1),
                        transpose_times(b, a.row2)};
  const auto ra = make_sh_rotation(a), rb = make_sh_rotation(b), rab = make_sh_rotation(ab);
  for (std::size_t i = 0; i < 5; ++i) {
    for (std::size_t k = 0; k < 5; ++k) {
      double product = 0, gram = 0;
      for (std::size_t m = 0; m < 5; ++m) {
        product += ra.degree2[i * 5 + m] * rb.degree2[m * 5 + k];
        gram += ra.degree2[i * 5 + m] * ra.degree2[k * 5 + m];
      }
      EXPECT_NEAR(product, rab.degree2[i * 5 + k], 1e-13);
      EXPECT_NEAR(gram, i == k, 1e-13);
    }
  }
}

TEST(ShRotation, HalfATurnAboutZOnlyChangesSigns) {
  const ShRotation rotation = make_sh_rotation({{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}});
  const double signs[7] = {-1, 1, -1, 1, -1, 1, -1};  // odd orders m change
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(rotation.degree3[i * 8], signs[i], 1e-14);
}

}  // namespace
}  // namespace fluxgs::math
