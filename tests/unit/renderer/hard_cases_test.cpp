// Splats that break renderers, each kind against the float64 reference (or, where float64 has no
// answer either, against what is said to come out). Views that break them: hard_views_test.cpp. The
// tolerance is that of ImageTest::expect_like() unless a test says otherwise.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "image_fixture.h"
#include "packed.h"
#include "render/scene_packing.h"

namespace fluxgs::test {
namespace {

class HardCasesTest : public ImageTest {};

constexpr float kPi = std::numbers::pi_v<float>;

glm::quat random_rotation(std::mt19937& random) {
  std::normal_distribution<float> normal;
  return glm::normalize(glm::quat(normal(random), normal(random), normal(random), normal(random)));
}

// Of half a million times their width; the determinant of their covariance has no bit left where it
// is computed as ad − b² in float32.
TEST_P(HardCasesTest, NeedleCovariances) {
  SplatCloud cloud;
  for (int i = 0; i < 12; ++i) {
    const float half_angle = kPi * static_cast<float>(i) / 24;
    add(cloud, {.scale = {0.8F, 1e-5F, 1e-5F},
                .rotation = {std::cos(half_angle), 0, 0, std::sin(half_angle)},
                .opacity = 0.9F,
                .color = {1, static_cast<float>(i) / 12, 0}});
  }
  expect_like_reference("needles", cloud, front_camera(200, 150, 1.5));
  cloud.log_scales.assign(12, {std::log(200.0F), std::log(1e-5F), std::log(1e-5F)});
  expect_like_reference("endless needles", cloud, front_camera(200, 150, 1.5));

  SplatCloud all_ways = random_cloud(600, 0, 11);
  std::mt19937 random(11);
  for (std::size_t i = 0; i < all_ways.size(); ++i) {
    all_ways.rotations[i] = random_rotation(random);
    all_ways.log_scales[i] = {-1.0F, -14.0F, i % 2 == 0 ? -14.0F : -1.0F};
  }
  expect_like_reference("needles and discs, all ways", all_ways,
                        orbit_camera(200, 150, {}, 2, 1, 7), kRose);
}

TEST_P(HardCasesTest, AcrossAndBehindTheNearPlane) {
  SplatCloud cloud;
  add(cloud, {.position = {0, 0, -5}});
  const Camera camera = front_camera(60, 60, 2);
  expect_like_reference("behind the camera", cloud, camera, kRose);
  expect_drawn(0);
  // Centres on both sides of the near plane at 0.01, bodies across it.
  for (const float z : {-2.2F, -1.995F, -1.9895F, -1.9F, -1.5F})
    add(cloud, {.position = {0.01F, 0.005F, z}, .scale = {0.2F, 0.01F, 0.3F}, .opacity = 0.3F});
  RenderOptions options = kRose;
  options.depth_spread_max = 0;
  expect_like_reference("across the near plane", cloud, camera, options);
  expect_drawn(3);
}

// A sheet seen from its edge, 20 units long, whose centre lies a little in front of the camera's
// plane and far aside: no ray of the image meets it, but linearised it would veil all of them.
TEST_P(HardCasesTest, SheetsThatReachBehindTheCameraDrawNoVeil) {
  SplatCloud cloud;
  add(cloud, {.position = {0, 0, 4}, .scale = {1, 1, 0.1F}, .opacity = 0.9F, .color = {0, 1, 0}});
  const Camera camera = front_camera(120, 90, 0);
  must(renderer().upload(cloud));
  const auto alone = draw(camera, kRose, TargetFormat::rgba16f, accurate());
  add(cloud, {.position = {2, 1, 0.15F}, .scale = {0.5F, 0.01F, 20}, .opacity = 0.9F});
  expect_like_reference("sheet", cloud, camera, kRose);
  EXPECT_EQ(draw(camera, kRose, TargetFormat::rgba16f, accurate()).pixels, alone.pixels);
  RenderOptions no_limit = kRose;
  no_limit.depth_spread_max = 0;
  expect_like_reference("sheet, without a limit", cloud, camera, no_limit);
  EXPECT_NE(draw(camera, no_limit, TargetFormat::rgba16f, accurate()).pixels, alone.pixels);
  // Long sheets beside the camera stay: what of them lies in front of it is as it should be
  cloud.log_scales[1].z = std::log(0.44F);
  expect_like_reference("shorter sheet", cloud, camera, kRose);
  expect_drawn(2);
}

// In directions from 20° to 89.4° off the axis, the image reaching to 27°: without a limit to the
// slopes of the Jacobian (1.3 times the field of view) all of them would lie over the image.
TEST_P(HardCasesTest, OffAxisJacobianBeyondTheFieldOfView) {
  SplatCloud cloud;
  for (int ring = 0; ring < 24; ++ring)
    for (int i = 0; i < 16; ++i) {
      const float slope = std::tan((20.0F + 3.02F * static_cast<float>(ring)) * kPi / 180);
      const float around = kPi * static_cast<float>(i) / 8 + 0.1F;
      const float z = i % 2 == 0 ? 1.0F : 0.05F;
      add(cloud, {.position = {z * slope * std::cos(around), z * slope * std::sin(around), z},
                  .scale = {0.3F * z, 0.1F * z, 0.5F * z},
                  .opacity = 0.5F,
                  .color = {1, static_cast<float>(ring) / 24, static_cast<float>(i) / 16}});
    }
  const Camera camera = front_camera(120, 120, 0);
  expect_like_reference("off axis", cloud, camera, kRose);
  for (const double margin : {0.0, 3.0})
    expect_like_reference("off axis, margin of " + std::to_string(margin).substr(0, 1), cloud,
                          camera, {.frustum_margin = margin});
}

// A quaternion means a direction only; the zero one, the identity.
TEST_P(HardCasesTest, ZeroTinyAndNonUnitQuaternions) {
  const std::array<float, 7> lengths = {0, 1e-38F, 1e-30F, 1e-3F, 7, 1e19F, 3e38F};
  SplatCloud cloud = random_cloud(350, 0, 12);
  std::mt19937 random(12);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.log_scales[i] = {-1.5F, -3.0F, -4.5F};
    cloud.rotations[i] = lengths[i % lengths.size()] * random_rotation(random);
  }
  const Camera camera = orbit_camera(160, 120, {}, 2, 1, 4);
  expect_like_reference("quaternions of any length", cloud, camera, kRose);

  const auto image_with = [&](const glm::quat& rotation) {
    std::ranges::fill(cloud.rotations, rotation);
    must(renderer().upload(cloud));
    return draw(camera, kRose, TargetFormat::rgba16f, accurate());
  };
  EXPECT_EQ(image_with({0, 0, 0, 0}).pixels, image_with({1, 0, 0, 0}).pixels);
}

// Each splat has the coefficients of its own degree and no others. The smallest half float in the
// others gives all splats degree 3: the image is the same but for a rounding, and takes more
// memory.
TEST_P(HardCasesTest, MixedDegreesOfSh) {
  const SplatCloud mixed = mixed_cloud(3000, 21);
  const Camera camera = orbit_camera(160, 120, {}, 2, 1, 4);
  for (int degree = 0; degree <= 3; ++degree)
    expect_like_reference("mixed degrees, " + std::to_string(degree) + " at most", mixed, camera,
                          {.sh_degree = degree});
  const auto image_of = [&](const SplatCloud& cloud) {
    must(renderer().upload(cloud));
    return draw(camera, kRose, TargetFormat::rgba16f, accurate()).pixels;
  };
  SplatCloud full = mixed;
  for (glm::vec3& c : full.sh_rest)
    if (c == glm::vec3(0)) c = glm::vec3(0x1p-24F);
  EXPECT_EQ(count_degrees(full), (DegreeCounts{0, 0, 0, 3000}));
  const std::pmr::vector<float> own = image_of(mixed), all = image_of(full);
  for (std::size_t i = 0; i < own.size(); ++i) ASSERT_NEAR(own[i], all[i], 0x1p-10F) << i;
  EXPECT_EQ(packed(full).sh.size(), 3000U * 12);
  EXPECT_EQ(packed(mixed).sh.size(), 750U * (3 + 6 + 12));
  // Bucket by bucket, as files have them: the same but for which of two equal depths is in front
  std::vector<std::uint32_t> by_degree(mixed.size());
  std::iota(by_degree.begin(), by_degree.end(), 0U);
  std::ranges::stable_sort(by_degree, {}, [&](std::uint32_t i) { return sh_degree_of(mixed, i); });
  expect_like_reference("mixed degrees, in buckets", in_order(mixed, by_degree), camera, kRose);
}

TEST_P(HardCasesTest, LogScalesBeyond15) {
  SplatCloud cloud = random_cloud(50, 0, 4);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.opacity_logits[i] = -1.5F;
    if (i % 2 == 0) cloud.log_scales[i] += static_cast<float>(i);  // up to e⁴⁵ units
  }
  expect_like_reference("huge splats", cloud, front_camera(161, 121, 2), kRose);

  const std::array<float, 9> values = {-200, -88, -15.5F, -15, -2, 15, 15.5F, 40, 100};
  SplatCloud mixed = random_cloud(729, 0, 13);
  for (std::size_t i = 0; i < mixed.size(); ++i) {
    mixed.opacity_logits[i] = i % 40 == 0 ? 1.0F : -4.5F;
    mixed.log_scales[i] = {values[i % 9], values[i / 9 % 9], values[i / 81]};
  }
  expect_like_reference("every mixture of scales", mixed, orbit_camera(161, 121, {}, 2, 1, 5),
                        kRose);
}

// From nearly nothing to opaque; nothing is left of the light from behind, or hardly.
TEST_P(HardCasesTest, AlphaNearOneAndLongRunsOfNoTransmittance) {
  SplatCloud walls = random_cloud(3000, 0, 5);
  for (std::size_t i = 0; i < walls.size(); ++i) {
    walls.log_scales[i] += 1.0F;
    walls.opacity_logits[i] = 20.0F;
  }
  expect_like_reference("opaque", walls, orbit_camera(160, 120, {}, 2, 1, 4));
  // Layers over the whole image: 500 of which each hides all but 1%, 3000 just above the cut-off.
  for (const auto& [label, layers, opacity] :
       {std::tuple{"500 layers of 0.99", 500, 0.9999F}, {"3000 layers of 0.004", 3000, 0.00401F}}) {
    SplatCloud cloud;
    for (int i = 0; i < layers; ++i) {
      const float depth = static_cast<float>(i) / static_cast<float>(layers);
      add(cloud, {.position = {0, 0, depth},
                  .scale = {1e3F, 1e3F, 1},
                  .opacity = opacity,
                  .color = {depth, 1 - depth, i % 2 == 0 ? 1 : 0}});
    }
    expect_like_reference(label, cloud, front_camera(17, 13, 2), kRose);
  }
}

// Nothing hides more than alpha_max of what is behind it. Tolerance: half a unit of a half float.
TEST_P(HardCasesTest, NoSplatIsFullyOpaque) {
  SplatCloud cloud;
  add(cloud, {.scale = {1e4F, 1e4F, 1}, .color = {0, 0, 0}});
  cloud.opacity_logits[0] = 30.0F;
  must(renderer().upload(cloud));
  for (const double alpha_max : {0.99, 0.5, 1.0}) {
    const RenderOptions options{.alpha_max = alpha_max, .background = {1, 1, 1}};
    const Image<float> image =
        draw(front_camera(8, 8, 2), options, TargetFormat::rgba16f, accurate());
    for (std::size_t i = 0; i < image.pixels.size(); i += 4) {
      EXPECT_NEAR(image.pixels[i], 1 - alpha_max, 5e-4);
      EXPECT_NEAR(image.pixels[i + 3], alpha_max, 1e-3);
    }
  }
}

// Of two splats at one depth the one with the smaller index lies in front, as in the reference.
TEST_P(HardCasesTest, ThousandCoplanarOfEqualDepth) {
  SplatCloud cloud = random_cloud(1000, 0, 1);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.positions[i] = 0.4F * cloud.positions[i];
    cloud.positions[i].z = 0.125F;
    cloud.log_scales[i] += 1.5F;
    cloud.sh_dc[i] *= 2.0F;
  }
  expect_like_reference("coplanar", cloud, front_camera(160, 120, 1));
}

TEST_P(HardCasesTest, HundredThousandUnitsFromTheOrigin) {
  const glm::vec3 centre(1e5F, -2e5F, 3e4F);
  SplatCloud cloud = random_cloud(2000, 1, 8, centre);
  expect_like_reference("far from the origin", cloud,
                        orbit_camera(200, 150, glm::dvec3(centre), 2, 1, 5));
}

// Dropped and counted: the image is, bit for bit, that of the others.
TEST_P(HardCasesTest, NanAndInfinityInAnyAttribute) {
  SplatCloud cloud = random_cloud(700, 1, 9);
  const Camera camera = orbit_camera(120, 90, {}, 2, 1, 4);
  std::size_t i = 0;
  for (const float value : {std::nanf(""), INFINITY, -INFINITY}) {
    cloud.positions[i++].y = value;
    cloud.log_scales[i++].x = value;
    cloud.rotations[i++].w = value;
    cloud.opacity_logits[i++] = value;
    cloud.sh_dc[i++].b = value;
    cloud.sh_rest[3 * i++ + 1].g = value;
  }
  const render::RenderCloud kept = cloud;
  EXPECT_EQ(render::ScenePacker(kept).undrawable(), i);
  SplatCloud without = cloud;
  EXPECT_EQ(drop_non_finite(without), i);
  expect_like_reference("non-finite", without, camera, kRose);
  const Image<float> expected = draw(camera, kRose, TargetFormat::rgba16f, accurate());
  must(renderer().upload(cloud));
  const Image<float> image = draw(camera, kRose, TargetFormat::rgba16f, accurate());
  EXPECT_EQ(image.pixels, expected.pixels);
}

bool finite(const Image<float>& image) {
  return std::ranges::all_of(image.pixels, [](float v) { return std::isfinite(v); });
}

// Finite, but beyond what float32 (or float64) can project: nothing of it may reach the image as
// NaN or infinity.
TEST_P(HardCasesTest, AbsurdButFiniteValues) {
  SplatCloud cloud = random_cloud(300, 1, 10);
  std::size_t i = 0;
  for (const float value : {3e38F, -3e38F, 1e20F, 1e14F, -1e14F, 1000.0F, -1000.0F, 1e-38F}) {
    cloud.positions[i++].z = value;
    cloud.positions[i++].x = value;
    cloud.log_scales[i++].x = value;
    cloud.rotations[i++] = {value, value, value, value};
    cloud.opacity_logits[i++] = value;
    cloud.sh_dc[i++].r = value;
    cloud.sh_rest[3 * i++].g = value;
  }
  must(renderer().upload(cloud));
  for (const TargetFormat format : {TargetFormat::rgba16f, TargetFormat::rgba8})
    EXPECT_TRUE(finite(draw(orbit_camera(64, 48, {}, 2, 1, 4), kRose, format, accurate())));
}

TEST_P(HardCasesTest, EmptySceneOneSplatAndOneOverTheWholeScreen) {
  const Camera camera = front_camera(97, 63, 2);
  expect_like_reference("empty scene", {}, camera, kRose);
  SplatCloud cloud;
  add(cloud, {.scale = {0.4F, 0.2F, 0.1F}, .color = {1, 0.5F, 0.25F}});
  expect_like_reference("one splat", cloud, camera);
  expect_like_reference("one splat on rose", cloud, camera, kRose);
  for (const float scale : {3.0F, 100.0F, 1e6F}) {
    cloud.log_scales[0] = glm::vec3(std::log(scale));
    expect_like_reference("over the screen, " + std::to_string(static_cast<int>(scale)) + " units",
                          cloud, camera, kRose);
  }
}

// Relative, over pixels of any brightness; infinite where one is not finite.
double greatest_relative_error(const Image<float>& image, const ReferenceImage& reference) {
  if (!finite(image)) return std::numeric_limits<double>::infinity();
  double greatest = 0;
  for (std::size_t i = 0; i < reference.transmittance.pixels.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const double wanted = reference.color.pixels[3 * i + c];
      const double error = static_cast<double>(image.pixels[4 * i + c]) - wanted;
      greatest = std::max(greatest, std::abs(error) / std::max(std::abs(wanted), 1.0));
    }
  return greatest;
}

// What comes out: colours are cut at 60,000, below the largest half float of 65,504, before they
// are blended, so that no sum of them overflows (the weights of a pixel's layers add up to 1 at
// most). Tolerance: 0.5%, a cut-off α of a splat included; 4% where every layer is rounded towards
// zero.
TEST_P(HardCasesTest, HalfFloatOverflowOfColors) {
  constexpr float kMax = 60'000;
  SplatCloud bright = random_cloud(400, 0, 14), cut = bright;
  const std::array<float, 8> colors = {0.5F, 100, 59'000, 65'504, 70'000, 1e6F, 1e12F, -1e12F};
  for (std::size_t i = 0; i < bright.size(); ++i) {
    const auto dc = [](float color) { return (color - 0.5F) / static_cast<float>(math::kSh0); };
    bright.log_scales[i] += 1.0F;
    for (int c = 0; c < 3; ++c) {
      const float color = colors[(i + static_cast<std::size_t>(3 * c)) % colors.size()];
      bright.sh_dc[i][c] = dc(color);
      cut.sh_dc[i][c] = dc(std::min(color, kMax));
    }
  }
  cut.log_scales = bright.log_scales;
  const Camera camera = orbit_camera(120, 90, {}, 2, 1, 4);
  const ReferenceImage reference = render_reference(cut, camera, kRose);
  must(renderer().upload(bright));
  for (const auto accumulation : {accurate(), Accumulation::half_float}) {
    const bool halves = accumulation == Accumulation::half_float;
    const Image<float> image = draw(camera, kRose, TargetFormat::rgba16f, accumulation);
    const double error = greatest_relative_error(image, reference);
    std::printf("%-7s colours up to 1e12, %s: greatest relative error %.5f\n",
                name_of(GetParam()).c_str(), halves ? "RGBA16F" : "RGBA32F", error);
    EXPECT_LE(error, halves ? 0.04 : 0.005);
  }
  const Image<float> bytes = draw(camera, kRose, TargetFormat::rgba8, accurate());
  const Difference d = compare(bytes, reference, true);
  print("colours up to 1e12 RGBA8", d);
  EXPECT_GE(d.psnr, 55);
}

// A projected splat of 16 bytes holds the inverse lengths of the axes as half floats
// (shaders/projected_splat.glsl). What comes out: axes longer than 13,914 px are drawn as if they
// had that length, and those shorter than 1/65504 px, which only a tiny dilation lets through,
// likewise. Tolerance: 45 dB, which it promises for ordinary scenes.
TEST_P(HardCasesTest, HalfFloatOverflowOfAxes) {
  const auto half =
      must(render::Renderer::create(api(), {.splat_precision = render::SplatPrecision::half}));
  const Camera camera = orbit_camera(160, 120, {}, 2, 1, 4);
  const auto check = [&](const std::string& label, const SplatCloud& cloud,
                         const RenderOptions& options) {
    must(half->upload(cloud));
    const Image<float> image = draw(*half, camera, options, TargetFormat::rgba16f, accurate());
    EXPECT_TRUE(finite(image)) << label;
    const Difference d = compare(image, render_reference(cloud, camera, options), false);
    print(label, d);
    keep_image(name_of(GetParam()) + "_" + label, image);
    return d.psnr;
  };
  SplatCloud cloud = random_cloud(60, 0, 15);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.opacity_logits[i] = -1.5F;
    cloud.sh_dc[i] *= 0.5F;
    if (i % 2 == 0) cloud.log_scales[i] += static_cast<float>(i);
    if (i % 3 == 0) cloud.log_scales[i].x = 20;
  }
  EXPECT_GE(check("half projected_splats, huge", cloud, kRose), 45);
  for (glm::vec3& scale : cloud.log_scales) scale = {-1.0F, -20.0F, -20.0F};
  EXPECT_GE(check("half projected_splats, needles", cloud, kRose), 45);
  RenderOptions sharp = kRose;
  sharp.filter = ScreenFilter{.dilation = 1e-12};
  EXPECT_GE(check("half projected_splats, no dilation", cloud, sharp), 45);
}

// Splats from far below to far above a pixel, whose opacities the filter changes.
TEST_P(HardCasesTest, CompensatedOpacities) {
  SplatCloud cloud = random_cloud(3000, 1, 23);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.log_scales[i] = glm::vec3(-9.0F + 0.002F * static_cast<float>(i));
    if (i % 4 == 0) cloud.log_scales[i].x = -2.0F;
    if (i % 7 == 0) cloud.log_scales[i].z = -30.0F;
  }
  cloud.filter = {.dilation = 0.3, .compensated = true};
  const Camera camera = orbit_camera(160, 120, {}, 2, 1, 4);
  expect_like_reference("compensated", cloud, camera, kRose);
  cloud.filter.dilation = 0.1;
  expect_like_reference("compensated, 0.1 px²", cloud, camera, kRose);
}

FLUXGS_GL_FORMS_TEST_SUITE(HardCasesTest);

}  // namespace
}  // namespace fluxgs::test
