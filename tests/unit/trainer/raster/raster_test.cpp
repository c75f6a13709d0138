// The CPU rasterizer against the float64 reference, on every instruction set this machine has.
#include "trainer/raster/rasterizer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <optional>

#include "support/scenes.h"
#include "tools/reference/reference_gradient.h"

namespace fluxgs {
namespace {

struct Rendered {
  PlanarImage color;
  PlanarFloats gradient;
  std::vector<std::uint8_t> visible;
  std::uint64_t rejected = 0;
};

/// A loss's gradient at one pixel, channel 1, instead of what it would be there.
struct BadPixel {
  int x = 0, y = 0;
  float value = 0;
};

/// ∂L/∂colour for a loss that weighs every pixel differently.
Image<double> pixel_weights(int width, int height) {
  Image<double> w(width, height, 3);
  for (std::size_t i = 0; i < w.pixels.size(); ++i)
    w.pixels[i] = std::sin(0.37 * static_cast<double>(i));
  return w;
}

Rendered run(const SplatCloud& cloud, const Camera& camera, const RenderOptions& options, Isa isa,
             int thread_count = 2, const std::optional<BadPixel>& bad = {}) {
  const Threads threads(thread_count);
  Profiler times;
  const auto rasterizer =
      make_cpu_rasterizer(threads, times, {.isa = isa, .count_pixel_pairs = false});
  const PlanarFloats parameters = to_parameters(cloud, cloud.sh_degree);
  rasterizer->forward(parameters, camera, options);
  PlanarImage weights(camera.width, camera.height, 3);
  const Image<double> w = pixel_weights(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      for (int c = 0; c < 3; ++c) weights.row(c, y)[x] = static_cast<float>(w.at(x, y)[c]);
  if (bad) weights.row(1, bad->y)[bad->x] = bad->value;
  rasterizer->backward(parameters, weights, nullptr);
  return {rasterizer->color(), rasterizer->gradient(), rasterizer->visible(),
          rasterizer->rejected_gradients()};
}

double largest_difference(const PlanarImage& image, const ReferenceImage& reference) {
  double worst = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      for (int c = 0; c < 3; ++c) {
        const double d = std::abs(double{image.row(c, y)[x]} - reference.color.at(x, y)[c]);
        worst = std::isnan(d) ? 1e9 : std::max(worst, d);
      }
  return worst;
}

/// Σ|a − b|² / Σ|b|² over one kind of parameter, as a square root.
struct RelativeError {
  double difference = 0, size = 0;
  void add(double a, double b) {
    difference += (a - b) * (a - b);
    size += b * b;
  }
  double value() const { return size > 0 ? std::sqrt(difference / size) : std::sqrt(difference); }
};

struct GradientErrors {
  RelativeError position, log_scale, rotation, opacity, sh_dc, sh_rest;
};

GradientErrors compare(const Rendered& fast, const ReferenceGradient& exact, std::size_t count,
                       int rest) {
  GradientErrors e;
  for (std::size_t i = 0; i < count; ++i) {
    const auto g = [&](int r) { return fast.visible[i] ? double{fast.gradient.row(r)[i]} : 0.0; };
    for (int c = 0; c < 3; ++c) {
      const auto k = static_cast<std::size_t>(c);
      e.position.add(g(row::position + c), exact.positions[i][k]);
      e.log_scale.add(g(row::log_scale + c), exact.log_scales[i][k]);
      e.sh_dc.add(g(row::sh_dc + c), exact.sh_dc[i][k]);
      for (int r = 0; r < rest; ++r)
        e.sh_rest.add(
            g(row::sh_rest + 3 * r + c),
            exact.sh_rest[i * static_cast<std::size_t>(rest) + static_cast<std::size_t>(r)][k]);
    }
    for (int c = 0; c < 4; ++c)
      e.rotation.add(g(row::rotation + c), exact.rotations[i][static_cast<std::size_t>(c)]);
    e.opacity.add(g(row::opacity), exact.opacity_logits[i]);
  }
  return e;
}

class CpuRaster : public testing::TestWithParam<Isa> {};
INSTANTIATE_TEST_SUITE_P(EveryIsa, CpuRaster, testing::ValuesIn(available_isas()),
                         [](const auto& isa) { return std::string(name_of(isa.param)); });

TEST_P(CpuRaster, ImageAndGradientsEqualTheReference) {
  for (int degree = 0; degree <= 3; ++degree) {
    const SplatCloud cloud = test::random_cloud(600, degree, 11, 0.8f, 0.06f);
    const Camera camera = test::camera_at({1.0, -0.7, -2.4}, {0, 0, 0}, 93, 71);
    RenderOptions options;
    options.background = {0.3, 0.1, 0.6};
    const Rendered fast = run(cloud, camera, options, GetParam());
    const auto reference = render_reference(cloud, camera, options);
    EXPECT_LT(largest_difference(fast.color, reference), 2e-5);
    const auto exact = reference_gradient(cloud, camera, options, pixel_weights(93, 71));
    const GradientErrors e = compare(fast, exact, cloud.size(), sh_rest_count(degree));
    EXPECT_LT(e.position.value(), 1e-4);
    EXPECT_LT(e.log_scale.value(), 1e-4);
    EXPECT_LT(e.rotation.value(), 1e-4);
    EXPECT_LT(e.opacity.value(), 1e-4);
    EXPECT_LT(e.sh_dc.value(), 5e-5);
    EXPECT_LT(e.sh_rest.value(), 5e-5);
  }
}

/// Sums are taken in sixteen parts, whatever the lanes. Without fused products bits differ.
TEST(CpuRasterBits, InstructionSetsWithFusedProductsGiveTheSame) {
  const std::vector<Isa> isas = available_isas();
  if (isas.size() < 3) GTEST_SKIP() << "needs AVX2 and AVX-512";
  const SplatCloud cloud = test::random_cloud(600, 3, 11, 0.8f, 0.06f);
  const Camera camera = test::camera_at({1.0, -0.7, -2.4}, {0, 0, 0}, 93, 71);
  const Rendered a = run(cloud, camera, {}, Isa::avx2), b = run(cloud, camera, {}, Isa::avx512);
  EXPECT_EQ(a.visible, b.visible);
  for (int c = 0; c < 3; ++c)
    EXPECT_EQ(std::memcmp(a.color.plane(c), b.color.plane(c), 4 * a.color.plane_size()), 0);
  for (int r = 0; r < a.gradient.rows(); ++r)
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (a.visible[i]) {
        ASSERT_EQ(a.gradient.row(r)[i], b.gradient.row(r)[i]) << r << ' ' << i;
      }
}

TEST_P(CpuRaster, CompensatedOpacitiesAndTheirGradientsEqualTheReference) {
  for (const float scale : {0.06f, 0.01f}) {  // some pixels, and a fraction of one
    SplatCloud cloud = test::random_cloud(600, 1, 12, 0.8f, scale);
    for (std::size_t i = 0; i < cloud.size(); i += 3) cloud.log_scales[i].x += 2;
    cloud.filter = {.dilation = 0.3, .compensated = true};
    const Camera camera = test::camera_at({1.0, -0.7, -2.4}, {0, 0, 0}, 93, 71);
    // Many opacities end near the ordinary cut-off, where rounding decides which splats are drawn
    const RenderOptions options = for_scene({.alpha_min = 1e-6}, cloud.filter);
    const Rendered fast = run(cloud, camera, options, GetParam());
    const auto reference = render_reference(cloud, camera, options);
    EXPECT_LT(largest_difference(fast.color, reference), 2e-5);
    const auto exact = reference_gradient(cloud, camera, options, pixel_weights(93, 71));
    const GradientErrors e = compare(fast, exact, cloud.size(), sh_rest_count(1));
    EXPECT_LT(e.position.value(), 1e-4);
    EXPECT_LT(e.log_scale.value(), 1e-4);
    EXPECT_LT(e.rotation.value(), 1e-4);
    EXPECT_LT(e.opacity.value(), 1e-4);
  }
}

/// Over a red background the red channel of a black scene is the transmittance of any scene of the
/// same shapes.
TEST_P(CpuRaster, TransmittanceAndItsGradientEqualTheReference) {
  const SplatCloud cloud = test::random_cloud(600, 1, 13, 0.8f, 0.06f);
  const Camera camera = test::camera_at({1.0, -0.7, -2.4}, {0, 0, 0}, 93, 71);
  const Threads threads(2);
  Profiler times;
  const auto rasterizer = make_cpu_rasterizer(threads, times, {.isa = GetParam()});
  const PlanarFloats parameters = to_parameters(cloud, cloud.sh_degree);
  rasterizer->forward(parameters, camera, {.background = {0.3, 0.1, 0.6}});

  SplatCloud black = cloud;
  black.sh_degree = 0;
  black.sh_rest.clear();
  for (glm::vec3& dc : black.sh_dc) dc = glm::vec3(-10);
  const RenderOptions over_red{.background = {1, 0, 0}};
  const auto reference = render_reference(black, camera, over_red);
  Image<double> weights = pixel_weights(93, 71);
  PlanarImage gradient(93, 71, 1);
  for (int y = 0; y < 71; ++y)
    for (int x = 0; x < 93; ++x) {
      EXPECT_NEAR(rasterizer->transmittance().row(0, y)[x], reference.color.at(x, y)[0], 2e-5);
      gradient.row(0, y)[x] = static_cast<float>(weights.at(x, y)[0]);
      weights.at(x, y)[1] = weights.at(x, y)[2] = 0;
    }
  rasterizer->backward(parameters, PlanarImage(93, 71, 3), &gradient);
  const auto exact = reference_gradient(black, camera, over_red, weights);
  const GradientErrors e =
      compare({rasterizer->color(), rasterizer->gradient(), rasterizer->visible(), 0}, exact,
              cloud.size(), 0);
  EXPECT_LT(e.position.value(), 1e-4);
  EXPECT_LT(e.log_scale.value(), 1e-4);
  EXPECT_LT(e.rotation.value(), 1e-4);
  EXPECT_LT(e.opacity.value(), 1e-4);
  EXPECT_EQ(e.sh_dc.value(), 0);
}

/// Compares the image and demands finite gradients; returns the largest difference.
double hard_case(const SplatCloud& cloud, const Camera& camera, const RenderOptions& options,
                 Isa isa) {
  const Rendered fast = run(cloud, camera, options, isa);
  for (int r = 0; r < fast.gradient.rows(); ++r)
    for (std::size_t i = 0; i < cloud.size(); ++i)
      if (fast.visible[i]) {
        EXPECT_TRUE(std::isfinite(fast.gradient.row(r)[i])) << "row " << r;
      }
  return largest_difference(fast.color, render_reference(cloud, camera, options));
}

TEST_P(CpuRaster, Needles) {
  SplatCloud cloud = test::random_cloud(200, 1, 3);
  for (glm::vec3& s : cloud.log_scales) s = {std::log(3.0f), std::log(1e-4f), std::log(1e-6f)};
  EXPECT_LT(hard_case(cloud, test::camera_in_front(160, 120), {}, GetParam()), 2e-3);
}

TEST_P(CpuRaster, CompensatedNeedlesAndDisks) {
  SplatCloud cloud = test::random_cloud(300, 1, 3);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud.log_scales[i] = i % 2 == 0 ? glm::vec3(std::log(3.0f), std::log(1e-3f), -40.0f)
                                     : glm::vec3(std::log(0.2f), std::log(0.3f), -40.0f);
  cloud.filter.compensated = true;
  EXPECT_LT(
      hard_case(cloud, test::camera_in_front(160, 120), for_scene({}, cloud.filter), GetParam()),
      2e-3);
}

TEST_P(CpuRaster, AcrossAndBehindTheNearPlane) {
  SplatCloud cloud = test::random_cloud(400, 2, 4, 0.5f, 0.1f);
  for (const double depth_spread_max : {3, 0})  // without a limit: all that reach behind the camera
    EXPECT_LT(hard_case(cloud, test::camera_in_front(64, 48, 0.1),
                        {.depth_spread_max = depth_spread_max}, GetParam()),
              1e-3);
}

TEST_P(CpuRaster, FarOffAxis) {
  SplatCloud cloud = test::random_cloud(300, 0, 5, 3.0f, 0.5f);
  EXPECT_LT(hard_case(cloud, test::camera_in_front(64, 48, 0.5, 40), {}, GetParam()), 1e-3);
}

TEST_P(CpuRaster, QuaternionsOfAnyLength) {
  SplatCloud cloud = test::random_cloud(90, 0, 6);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud.rotations[i] *= i % 3 == 0 ? 0.0f : i % 3 == 1 ? 1e-30f : 1e10f;
  EXPECT_LT(hard_case(cloud, test::camera_in_front(64, 48), {}, GetParam()), 1e-4);
}

TEST_P(CpuRaster, ExtremeScales) {
  SplatCloud cloud = test::random_cloud(60, 0, 7);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud.log_scales[i] =
        glm::vec3(i % 2 ? 15.0f : -15.0f, i % 3 ? 15.0f : -15.0f, i % 5 ? 16.0f : -16.0f);
  EXPECT_LT(hard_case(cloud, test::camera_in_front(40, 30), {}, GetParam()), 1e-3);
}

TEST_P(CpuRaster, OpaqueLayers) {
  SplatCloud cloud = test::random_cloud(300, 0, 8, 0.3f, 0.3f);
  for (float& o : cloud.opacity_logits) o = 12.0f;
  EXPECT_LT(hard_case(cloud, test::camera_in_front(48, 48), {}, GetParam()), 2e-5);
}

TEST_P(CpuRaster, ThousandCoplanarSplatsOfEqualDepth) {
  SplatCloud cloud = test::random_cloud(1000, 0, 9, 0.5f, 0.1f);
  for (glm::vec3& p : cloud.positions) p.z = 0.25f;
  EXPECT_LT(hard_case(cloud, test::camera_in_front(64, 64), {}, GetParam()), 2e-5);
}

TEST_P(CpuRaster, FarFromTheOrigin) {
  SplatCloud cloud = test::random_cloud(200, 0, 10);
  const glm::vec3 shift(1e5f, -1e5f, 1e5f);
  for (glm::vec3& p : cloud.positions) p += shift;
  const glm::dvec3 target(shift);
  const Camera camera = test::camera_at(target + glm::dvec3(0.5, 0.25, -4), target, 64, 64);
  // Positions carry steps of 1/128 there: single precision may move a splat by half of one.
  EXPECT_LT(hard_case(cloud, camera, {}, GetParam()), 0.15);
}

TEST_P(CpuRaster, NonFiniteSplatsAreNotDrawn) {
  SplatCloud cloud = test::random_cloud(50, 1, 12);
  const SplatCloud good = cloud;
  const float nan = std::nanf(""), inf = INFINITY;
  cloud.resize(57);
  for (std::size_t i = 50; i < 57; ++i) {
    cloud.rotations[i] = glm::quat(1, 0, 0, 0);
    cloud.opacity_logits[i] = 2;
  }
  cloud.positions[50].x = nan;
  cloud.positions[51].z = inf;
  cloud.log_scales[52].y = inf;
  cloud.rotations[53].w = nan;
  cloud.opacity_logits[54] = nan;
  cloud.sh_dc[55].x = inf;
  cloud.sh_rest[56 * 3].z = nan;
  const Camera camera = test::camera_in_front(64, 48);
  const Rendered with = run(cloud, camera, {}, GetParam());
  EXPECT_LT(largest_difference(with.color, render_reference(good, camera, {})), 2e-5);
  for (std::size_t i = 50; i < 57; ++i) EXPECT_EQ(with.visible[i], 0) << i;
}

TEST_P(CpuRaster, PixelsThatAreNotFiniteCostOnlyTheSplatsInThem) {
  const SplatCloud cloud = test::random_cloud(600, 2, 21, 0.8f, 0.04f);
  const Camera camera = test::camera_in_front(93, 71);
  const Rendered clean = run(cloud, camera, {}, GetParam());
  ASSERT_EQ(clean.rejected, 0u);
  for (const float value : {std::nanf(""), INFINITY, -INFINITY}) {
    const Rendered bad = run(cloud, camera, {}, GetParam(), 2, BadPixel{46, 35, value});
    std::uint64_t lost = 0, seen = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      lost += clean.visible[i] != bad.visible[i];
      seen += clean.visible[i];
      if (!bad.visible[i]) continue;
      for (int r = 0; r < bad.gradient.rows(); ++r)
        ASSERT_EQ(bad.gradient.row(r)[i], clean.gradient.row(r)[i]) << "row " << r << ", " << i;
    }
    EXPECT_EQ(bad.rejected, lost) << value;
    EXPECT_GT(lost, 0u) << value;
    EXPECT_LT(lost, seen / 4) << value << ", of " << seen;
  }
}

TEST_P(CpuRaster, SmallAndOddImages) {
  const SplatCloud cloud = test::random_cloud(100, 0, 13);
  for (auto [w, h] : {std::pair{1, 1}, {1, 7}, {17, 15}, {16, 16}, {31, 1}, {33, 65}})
    EXPECT_LT(hard_case(cloud, test::camera_in_front(w, h), {}, GetParam()), 2e-5) << w << "x" << h;
}

TEST_P(CpuRaster, EmptySceneAndOneSplatOverTheWholeScreen) {
  RenderOptions options;
  options.background = {0.5, 0.25, 0.125};
  options.depth_spread_max = 0;
  EXPECT_EQ(hard_case(SplatCloud{}, test::camera_in_front(20, 20), options, GetParam()), 0.0);
  EXPECT_LT(hard_case(test::one_splat({0, 0, 0}, 50.0f, 3.0f), test::camera_in_front(200, 100),
                      options, GetParam()),
            1e-6);
}

TEST_P(CpuRaster, SameBytesForAnyNumberOfThreads) {
  const SplatCloud cloud = test::random_cloud(20000, 3, 14, 1.0f, 0.03f);
  const Camera camera = test::camera_in_front(200, 150);
  const Rendered one = run(cloud, camera, {}, GetParam(), 1);
  for (int threads : {2, 4}) {
    const Rendered many = run(cloud, camera, {}, GetParam(), threads);
    ASSERT_EQ(one.visible, many.visible);
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < 150; ++y)
        ASSERT_EQ(0, std::memcmp(one.color.row(c, y), many.color.row(c, y), 200 * sizeof(float)));
    for (int r = 0; r < one.gradient.rows(); ++r)
      for (std::size_t i = 0; i < cloud.size(); ++i)
        if (one.visible[i]) {
          ASSERT_EQ(one.gradient.row(r)[i], many.gradient.row(r)[i]);
        }
  }
}

}  // namespace
}  // namespace fluxgs
