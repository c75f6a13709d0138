// The footprint of a splat in single precision against the textbook form: Σ = A·Aᵀ + 0.3·I,
// inverted by ad − b² (3DGS). Needles are what the textbook loses.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fluxgs/math/projection.h"
#include "support.h"

namespace fluxgs::math {
namespace {

constexpr float kDilation = 0.3f;

template <class T>
struct Covariance {
  T a, b, c, det;
};

template <class T>
Covariance<T> textbook(const ScreenAxes<float>& axes) {
  const auto cast = [](const Vec3<float>& v) { return Vec3<T>{T(v.x), T(v.y), T(v.z)}; };
  const Vec3<T> x = cast(axes.x), y = cast(axes.y);
  const T a = dot(x, x) + T(kDilation), b = dot(x, y), c = dot(y, y) + T(kDilation);
  return {a, b, c, a * c - b * b};
}

// d·Σ⁻¹·d
template <class T>
T quadratic(const Covariance<T>& s, T dx, T dy) {
  return (s.c * dx * dx - 2 * s.b * dx * dy + s.a * dy * dy) / s.det;
}

template <class T>
T quadratic(const Footprint<T>& f, T dx, T dy) {
  const T u = f.xx * dx + f.xy * dy, v = f.yy * dy;
  return u * u + v * v;
}

struct Errors {
  std::vector<double> stable, textbook, determinant, textbook_determinant;
  int negative = 0;

  static double percentile(std::vector<double> values, double p) {
    std::ranges::sort(values);
    return values[static_cast<std::size_t>(p * static_cast<double>(values.size() - 1))];
  }
};

// Splats with one axis of `longest` px and two of `shortest` px in random directions, at pixels of
// their footprint (u, v normal, so the quadratic form is of order 1).
Errors measure(float longest, float shortest, int count = 20000) {
  std::mt19937 random(9);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> angle(0, 2 * std::numbers::pi_v<float>);
  Errors errors;
  for (int i = 0; i < count; ++i) {
    const float t = angle(random), c = std::cos(t), s = std::sin(t);
    const ScreenAxes<float> axes{{longest * c, -shortest * s, shortest * normal(random)},
                                 {longest * s, shortest * c, shortest * normal(random)}};
    const auto exact = textbook<long double>(axes);
    const auto plain = textbook<float>(axes);
    const Footprint<float> stable = footprint(axes, kDilation);
    // A pixel from the exact Cholesky factor of Σ, rounded to float before anything is compared.
    const long double l11 = std::sqrt(exact.a), l21 = exact.b / l11,
                      l22 = std::sqrt(exact.det / exact.a);
    const float u = normal(random), v = normal(random);
    const float dx = static_cast<float>(l11 * u), dy = static_cast<float>(l21 * u + l22 * v);
    const long double q = quadratic<long double>(exact, dx, dy);
    const auto relative = [](long double value, long double reference) {
      return static_cast<double>(std::abs(value - reference) / reference);
    };
    errors.stable.push_back(relative(quadratic(stable, dx, dy), q));
    errors.textbook.push_back(relative(quadratic(plain, dx, dy), q));
    const long double product = static_cast<long double>(stable.xx) * stable.yy;
    errors.determinant.push_back(relative(1 / (product * product), exact.det));
    errors.textbook_determinant.push_back(relative(plain.det, exact.det));
    errors.negative += plain.det <= 0;
  }
  return errors;
}

void print(const char* name, float longest, float shortest, const Errors& e) {
  std::printf(
      "%s %g x %g px: form median %.1e 99%% %.1e (textbook %.1e, %.1e); determinant max %.1e "
      "(textbook median %.1e max %.1e, %d of %zu not positive)\n",
      name, double{longest}, double{shortest}, Errors::percentile(e.stable, 0.5),
      Errors::percentile(e.stable, 0.99), Errors::percentile(e.textbook, 0.5),
      Errors::percentile(e.textbook, 0.99), Errors::percentile(e.determinant, 1),
      Errors::percentile(e.textbook_determinant, 0.5),
      Errors::percentile(e.textbook_determinant, 1), e.negative, e.stable.size());
}

TEST(Footprint, OrdinarySplatsAgreeWithTheTextbook) {
  for (const auto& [longest, shortest] : {std::pair(1.0f, 1.0f), std::pair(5.0f, 2.0f),
                                          std::pair(0.01f, 0.01f), std::pair(20.0f, 20.0f)}) {
    const Errors e = measure(longest, shortest);
    print("ordinary", longest, shortest, e);
    EXPECT_LT(Errors::percentile(e.stable, 0.99), 1e-5);
    EXPECT_LT(Errors::percentile(e.determinant, 1), 1e-6);
  }
}

TEST(Footprint, NeedlesKeepTheirDeterminantWhereTheTextbookLosesIt) {
  for (const float longest : {100.0f, 1000.0f, 3000.0f, 1e4f, 1e5f}) {
    const Errors e = measure(longest, 0.01f);
    print("needle", longest, 0.01f, e);
    EXPECT_LT(Errors::percentile(e.determinant, 1), 1e-6);
    // One rounding of a coefficient moves the form of a needle by its length over its width: that
    // is all that single precision allows. The textbook loses the square of it.
    EXPECT_LT(Errors::percentile(e.stable, 0.99), 2e-7 * double{longest});
    EXPECT_LT(20 * Errors::percentile(e.stable, 0.5), Errors::percentile(e.textbook, 0.5));
  }
  const Errors e = measure(3000, 0.01f);
  EXPECT_GT(Errors::percentile(e.textbook_determinant, 0.5), 0.1);
  EXPECT_GT(e.negative, 0);
}

TEST(Footprint, ExtentsAreTheSquareRootsOfTheDiagonal) {
  const ScreenAxes<double> axes{{3, 1, 0}, {0, 2, 1}};
  const Footprint<double> f = footprint(axes, 0.3);
  EXPECT_NEAR(f.deviation_x, std::sqrt(10.3), 1e-12);
  EXPECT_NEAR(f.deviation_y, std::sqrt(5.3), 1e-12);
  // ΛᵀΛ is the inverse of the covariance.
  const double det = 10.3 * 5.3 - 4;
  EXPECT_NEAR(f.xx * f.xx, 5.3 / det, 1e-12);
  EXPECT_NEAR(f.xx * f.xy, -2 / det, 1e-12);
  EXPECT_NEAR(f.xy * f.xy + f.yy * f.yy, 10.3 / det, 1e-12);
}

// Log-scales of ±15 and axes of 1e10 px: finite, and the dilation keeps the smallest visible.
TEST(Footprint, ExtremeScalesStayFinite) {
  for (const float x : {std::exp(-15.0f), std::exp(15.0f), 1e10f, 0.0f, 1e18f}) {
    for (const float y : {std::exp(-15.0f), std::exp(15.0f), 1e10f, 0.0f}) {
      const ScreenAxes<float> axes{{x, 0, 0}, {0, y, 0}};
      const Footprint<float> f = footprint(axes, kDilation);
      for (const float value : {f.xx, f.yy, f.deviation_x, f.deviation_y}) {
        EXPECT_TRUE(std::isfinite(value) && value > 0) << x << ' ' << y;
      }
      EXPECT_TRUE(std::isfinite(f.xy));
      const double deviation = std::sqrt(double{x} * x + double{kDilation});
      EXPECT_NEAR(f.deviation_x / deviation, 1, 1e-6);
      EXPECT_NEAR(f.xx * deviation, 1, 1e-5) << x << ' ' << y;
    }
  }
}

TEST(Footprint, CompensationIsTheRootOfTheRatioOfDeterminants) {
  for (const double length : {0.01, 1.0, 100.0, 1e4})
    for (const double width : {1e-4, 0.1, 1.0, 50.0}) {
      const ScreenAxes<double> axes{{length, 0.5 * width, 0}, {0.25 * length, width, 0}};
      const double det = std::pow(length * width * (1 - 0.125), 2);
      const double trace = dot(axes.x, axes.x) + dot(axes.y, axes.y);
      const double expected = std::sqrt(det / (det + 0.3 * trace + 0.09));
      EXPECT_NEAR(opacity_compensation(axes, 0.3) / expected, 1, 1e-12);
      const ScreenAxes<float> single{
          {static_cast<float>(length), static_cast<float>(0.5 * width), 0},
          {static_cast<float>(0.25 * length), static_cast<float>(width), 0}};
      EXPECT_NEAR(opacity_compensation(single, 0.3f) / expected, 1, 2e-5) << length << ' ' << width;
    }
  // A disk seen from its side has no area; nothing has a compensation that is no number
  EXPECT_EQ(opacity_compensation(ScreenAxes<float>{{5, 0, 0}, {3, 0, 0}}, 0.3f), 0);
  EXPECT_EQ(opacity_compensation(ScreenAxes<float>{{0, 0, 0}, {0, 0, 0}}, 0.3f), 0);
  EXPECT_NEAR(opacity_compensation(ScreenAxes<float>{{1e10f, 0, 0}, {0, 1e10f, 0}}, 0.3f), 1, 1e-6);
}

// The full chain from a splat to its axes on the screen, against numbers worked out by hand.
TEST(Footprint, AxesOfASplatByHand) {
  const Jacobian<double> j{60, -15, 55, -6.875, 0.25, 0.125};
  const Mat3<double> identity{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const ScreenAxes<double> axes = screen_axes(j, identity, identity, {0.1, 0.2, 0.4});
  EXPECT_NEAR(axes.x.x, 6, 1e-12);
  EXPECT_NEAR(axes.x.y, 0, 1e-12);
  EXPECT_NEAR(axes.x.z, -6, 1e-12);
  EXPECT_NEAR(axes.y.y, 11, 1e-12);
  EXPECT_NEAR(axes.y.z, -2.75, 1e-12);
}

}  // namespace
}  // namespace fluxgs::math
