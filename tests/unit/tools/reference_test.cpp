// The reference renderer against closed forms, and its gradient against central differences.
#include "tools/reference/reference_renderer.h"

#include <gtest/gtest.h>

#include <functional>
#include <numbers>

#include "support/scenes.h"
#include "tools/reference/reference_gradient.h"

namespace fluxgs {
namespace {

using test::camera_in_front;
using test::one_splat;

double sigmoid(double x) { return 1 / (1 + std::exp(-x)); }

TEST(ReferenceRenderer, EmptySceneIsBackground) {
  RenderOptions options;
  options.background = {0.25, 0.5, 0.75};
  const auto image = render_reference(SplatCloud{}, camera_in_front(3, 2), options);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(image.color.pixels[3 * i], 0.25);
    EXPECT_EQ(image.color.pixels[3 * i + 2], 0.75);
    EXPECT_EQ(image.transmittance.pixels[i], 1.0);
  }
}

TEST(ReferenceRenderer, OneRoundSplatIsAGaussian) {
  const Camera camera = camera_in_front(33, 33, 4.0, 100.0);
  const double deviation = 0.1, logit = 0.8;
  RenderOptions options;
  const auto image = render_reference(
      one_splat({0, 0, 0}, static_cast<float>(deviation), static_cast<float>(logit)), camera,
      options);
  // On the axis the Jacobian is (f/z)·I, so the variance on the screen is (f·σ/z)² + 0.3.
  const double variance = std::pow(100.0 * deviation / 4.0, 2) + 0.3;
  for (int y = 0; y < 33; ++y)
    for (int x = 0; x < 33; ++x) {
      const double dx = x + 0.5 - 16.5, dy = y + 0.5 - 16.5;
      double alpha = sigmoid(logit) * std::exp(-(dx * dx + dy * dy) / (2 * variance));
      if (alpha < options.alpha_min) alpha = 0;
      const double red = (0.5 + 0.28209479177387814) * alpha;
      EXPECT_NEAR(*image.color.at(x, y), red, 2e-8) << x << ", " << y;
      EXPECT_NEAR(*image.transmittance.at(x, y), 1 - alpha, 2e-8);
    }
}

/// Σ α over the image of one round splat, whose α stay far below the limit.
double total_alpha(double deviation, const ScreenFilter& filter) {
  SplatCloud cloud = one_splat({0, 0, 0}, static_cast<float>(deviation), -1.0f);
  cloud.filter = filter;
  RenderOptions options;
  options.alpha_min = 1e-9;
  const auto image = render_reference(cloud, camera_in_front(65, 65, 4.0, 100.0), options);
  double sum = 0;
  for (const double t : image.transmittance.pixels) sum += 1 - t;
  return sum;
}

// A Gaussian of opacity o and variance v covers 2π·o·v pixels, however much it is widened.
TEST(ReferenceRenderer, CompensatedSplatsKeepTheirTotalWeight) {
  for (const double pixels : {0.05, 0.3, 1.0, 4.0}) {
    const double covered = 2 * std::numbers::pi * sigmoid(-1.0) * pixels * pixels;
    const double deviation = pixels * 4.0 / 100.0;
    for (const double dilation : {0.3, 0.6}) {
      const double compensated = total_alpha(deviation, {dilation, true});
      const double classic = total_alpha(deviation, {dilation, false});
      // The splat's centre is a pixel's: sampling a Gaussian of variance 0.3 errs by 1 %
      EXPECT_NEAR(compensated / covered, 1, 0.02) << pixels << ' ' << dilation;
      EXPECT_NEAR(classic / compensated, 1 + dilation / (pixels * pixels), 1e-3);
    }
  }
}

TEST(ReferenceRenderer, TheFilterOfTheOptionsComesBeforeThatOfTheScene) {
  SplatCloud cloud = one_splat({0, 0, 0}, 0.01f, 1.0f);
  cloud.filter = {0.5, true};
  const Camera camera = camera_in_front(9, 9);
  const auto own = render_reference(cloud, camera, {});
  const auto classic = render_reference(cloud, camera, {.filter = ScreenFilter{}});
  cloud.filter = {};
  EXPECT_EQ(render_reference(cloud, camera, {}).color.pixels, classic.color.pixels);
  EXPECT_NE(own.color.pixels, classic.color.pixels);
}

TEST(ReferenceRenderer, TwoSplatsBlendFrontToBack) {
  const Camera camera = camera_in_front(17, 17, 4.0, 100.0);
  SplatCloud cloud = one_splat({0, 0, 1}, 0.5f, 1.0f, {1, 1, 1});
  cloud.resize(2);  // the second one is nearer
  cloud.positions[1] = {0, 0, -1};
  cloud.log_scales[1] = cloud.log_scales[0];
  cloud.opacity_logits[1] = -0.5f;
  cloud.sh_dc[1] = {-1, 0, 1};
  RenderOptions options;
  options.background = {0.1, 0.2, 0.3};
  const auto image = render_reference(cloud, camera, options);
  const double near_alpha = sigmoid(-0.5), far_alpha = sigmoid(1.0);
  for (int c = 0; c < 3; ++c) {
    const double near_color = 0.5 + 0.28209479177387814 * (c - 1);
    const double far_color = 0.5 + 0.28209479177387814;
    const double expected = near_color * near_alpha + far_color * far_alpha * (1 - near_alpha) +
                            (1 - near_alpha) * (1 - far_alpha) * options.background[c];
    EXPECT_NEAR(image.color.at(8, 8)[c], expected, 1e-7);
  }
}

TEST(ReferenceRenderer, EqualDepthsBlendInOrderOfIndex) {
  const Camera camera = camera_in_front(9, 9, 4.0, 100.0);
  SplatCloud cloud = one_splat({0, 0, 0}, 0.5f, 0.0f, {1, 1, 1});
  cloud.resize(2);
  cloud.log_scales[1] = cloud.log_scales[0];
  cloud.sh_dc[1] = {-1, -1, -1};
  const auto image = render_reference(cloud, camera, {});
  const double first = 0.5 + 0.28209479177387814, second = 0.5 - 0.28209479177387814;
  EXPECT_NEAR(*image.color.at(4, 4), 0.5 * first + 0.25 * second, 1e-7);
}

TEST(ReferenceRenderer, NeedleFollowsItsAxis) {
  // 200 px long and thinner than the dilation, at 30° on the screen.
  const double angle = std::numbers::pi / 6, along = 2.0, across = 1e-6;
  SplatCloud cloud = one_splat({0, 0, 0}, 1.0f, 4.0f);
  cloud.log_scales[0] = {static_cast<float>(std::log(along)), static_cast<float>(std::log(across)),
                         static_cast<float>(std::log(across))};
  cloud.rotations[0] = glm::quat(static_cast<float>(std::cos(angle / 2)), 0.0f, 0.0f,
                                 static_cast<float>(std::sin(angle / 2)));
  const Camera camera = camera_in_front(201, 201, 4.0, 400.0);
  RenderOptions options;
  options.frustum_margin = 10;
  const auto image = render_reference(cloud, camera, options);
  const double long_variance = std::pow(400 * along / 4, 2) + 0.3, thin_variance = 0.3;
  for (int step = -60; step <= 60; step += 7) {
    const int x = 100 + step, y = 100 + static_cast<int>(std::lround(step * std::tan(angle)));
    const double dx = x - 100.0, dy = y - 100.0;
    const double l = dx * std::cos(angle) + dy * std::sin(angle);
    const double t = -dx * std::sin(angle) + dy * std::cos(angle);
    double alpha = sigmoid(4.0) * std::exp(-0.5 * (l * l / long_variance + t * t / thin_variance));
    if (alpha < options.alpha_min) alpha = 0;
    EXPECT_NEAR(*image.transmittance.at(x, y), 1 - alpha, 1e-5) << step;
  }
}

TEST(ReferenceRenderer, SplatBehindTheCameraIsNotDrawn) {
  const auto image =
      render_reference(one_splat({0, 0, -5}, 0.5f, 3.0f), camera_in_front(9, 9), RenderOptions{});
  for (double t : image.transmittance.pixels) EXPECT_EQ(t, 1.0);
}

TEST(ReferenceRenderer, PixelsFinishBelowTheLeastTransmittance) {
  // 0.99 limits α: two opaque layers leave 1e-4, a third leaves 1e-6 < T_min; a fourth adds
  // nothing.
  SplatCloud cloud = one_splat({0, 0, 0}, 1.0f, 20.0f, {0, 0, 0});
  for (std::size_t n = 1; n < 6; ++n) {
    cloud.resize(n + 1);
    cloud.positions[n] = {0, 0, 0.1f * static_cast<float>(n)};
    cloud.log_scales[n] = glm::vec3(0);
    cloud.opacity_logits[n] = 20.0f;
  }
  RenderOptions options;
  const auto image = render_reference(cloud, camera_in_front(5, 5, 4.0, 100.0), options);
  EXPECT_NEAR(*image.transmittance.at(2, 2), 1e-6, 1e-12);
}

/// ∂L/∂x for L = Σ weight·colour by central differences.
double central_difference(const Image<double>& weight,
                          const std::function<Image<double>(double)>& render, double step) {
  const Image<double> plus = render(step), minus = render(-step);
  double total = 0;
  for (std::size_t i = 0; i < weight.pixels.size(); ++i)
    total += weight.pixels[i] * (plus.pixels[i] - minus.pixels[i]);
  return total / (2 * step);
}

struct GradientCase {
  const char* name;
  std::function<void(SplatCloud&, std::size_t, double)> change;  // adds to one parameter
  std::function<double(const ReferenceGradient&, std::size_t)> analytic;
};

std::vector<GradientCase> gradient_cases() {
  std::vector<GradientCase> cases;
  const auto add = [](float& value, double step) { value = static_cast<float>(value + step); };
  for (int c = 0; c < 3; ++c) {
    const auto k = static_cast<std::size_t>(c);
    cases.push_back({"position",
                     [=](SplatCloud& s, std::size_t i, double h) { add(s.positions[i][c], h); },
                     [=](const ReferenceGradient& g, std::size_t i) { return g.positions[i][k]; }});
    cases.push_back(
        {"log_scale", [=](SplatCloud& s, std::size_t i, double h) { add(s.log_scales[i][c], h); },
         [=](const ReferenceGradient& g, std::size_t i) { return g.log_scales[i][k]; }});
    cases.push_back({"sh_dc",
                     [=](SplatCloud& s, std::size_t i, double h) { add(s.sh_dc[i][c], h); },
                     [=](const ReferenceGradient& g, std::size_t i) { return g.sh_dc[i][k]; }});
    for (std::size_t r = 0; r < 15; ++r)
      cases.push_back(
          {"sh_rest",
           [=](SplatCloud& s, std::size_t i, double h) { add(s.sh_rest[15 * i + r][c], h); },
           [=](const ReferenceGradient& g, std::size_t i) { return g.sh_rest[15 * i + r][k]; }});
  }
  cases.push_back({"opacity",
                   [=](SplatCloud& s, std::size_t i, double h) { add(s.opacity_logits[i], h); },
                   [](const ReferenceGradient& g, std::size_t i) { return g.opacity_logits[i]; }});
  for (int c = 0; c < 4; ++c)
    cases.push_back({"rotation",
                     [=](SplatCloud& s, std::size_t i, double h) {
                       glm::quat& q = s.rotations[i];
                       add(c == 0 ? q.w : c == 1 ? q.x : c == 2 ? q.y : q.z, h);
                     },
                     [=](const ReferenceGradient& g, std::size_t i) {
                       return g.rotations[i][static_cast<std::size_t>(c)];
                     }});
  return cases;
}

// Parameters are stored as float32, so steps are powers of two, which they hold exactly around
// values that have been rounded to multiples of the step.
void expect_central_differences(const ScreenFilter& filter, float scale) {
  const double step = std::ldexp(1.0, -12);
  SplatCloud cloud = test::random_cloud(8, 3, 5, 0.5f, scale);
  cloud.filter = filter;
  const auto snap = [&](float& v) { v = static_cast<float>(std::round(v / step) * step); };
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (int c = 0; c < 3; ++c)
      snap(cloud.positions[i][c]), snap(cloud.log_scales[i][c]), snap(cloud.sh_dc[i][c]);
    snap(cloud.rotations[i].w), snap(cloud.rotations[i].x), snap(cloud.rotations[i].y),
        snap(cloud.rotations[i].z);
    snap(cloud.opacity_logits[i]);
  }
  for (glm::vec3& v : cloud.sh_rest)
    for (int c = 0; c < 3; ++c) snap(v[c]);

  const Camera camera = test::camera_at({1.2, -0.8, -3}, {0.2, 0.1, 0}, 24, 20);
  RenderOptions options;
  options.alpha_min = 1e-12;  // no jumps at the ellipse's rim
  options.background = {0.2, 0.4, 0.1};
  Image<double> weight(24, 20, 3);
  for (std::size_t i = 0; i < weight.pixels.size(); ++i)
    weight.pixels[i] = std::sin(0.7 * static_cast<double>(i));
  const ReferenceGradient gradient = reference_gradient(cloud, camera, options, weight);

  for (const GradientCase& c : gradient_cases()) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const auto render = [&](double h) {
        SplatCloud moved = cloud;
        c.change(moved, i, h);
        return render_reference(moved, camera, options).color;
      };
      // Richardson: the error of order step² cancels
      const double coarse = central_difference(weight, render, 2 * step);
      const double fine = central_difference(weight, render, step);
      const double expected = (4 * fine - coarse) / 3;
      EXPECT_NEAR(c.analytic(gradient, i), expected, 1e-6 * (1 + std::abs(expected)))
          << c.name << " of splat " << i;
    }
  }
}

TEST(ReferenceGradient, EqualsCentralDifferencesForEveryParameter) {
  expect_central_differences({}, 0.3f);
}

TEST(ReferenceGradient, EqualsCentralDifferencesOfCompensatedOpacities) {
  expect_central_differences({.dilation = 0.3, .compensated = true}, 0.3f);
  expect_central_differences({.dilation = 0.1, .compensated = true}, 0.05f);
}

}  // namespace
}  // namespace fluxgs
