// Whole pictures against the float64 reference.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <numbers>

#include "gl_fixture.h"
#include "scenes.h"

namespace fluxgs::test {
namespace {

using render::Accumulation;
using render::RenderTarget;
using render::TargetFormat;

class PictureTest : public GlTest {
 protected:
  Image<float> picture(const Camera& camera, const RenderOptions& options, TargetFormat format,
                       Accumulation accumulation) {
    const RenderTarget target =
        must(RenderTarget::create(api(), camera.width, camera.height, format, accumulation));
    must(renderer().draw(camera, options, target));
    return must(renderer().read(target));
  }

  Accumulation accurate() { return render::accurate_accumulation(api().capabilities); }

  void print(const std::string& label, const Difference& d) {
    std::printf("%-7s %-36s PSNR %6.2f dB, greatest error %.5f\n",
                std::string(host::name(GetParam())).c_str(), label.c_str(), d.psnr, d.greatest);
  }

  // Draws the cloud in both formats; prints a line for each.
  void expect_like_reference(const std::string& name, const SplatCloud& cloud, const Camera& camera,
                             const RenderOptions& options = {}) {
    must(renderer().upload(cloud));
    const ReferenceImage reference = render_reference(cloud, camera, options);
    // The project promises 50 and 45 dB. Where layers are blended in float32 only the last
    // rounding is left: at worst one unit of a half float below 1, half a unit of 8 bits (58.9 dB).
    const bool exact = accurate() == Accumulation::single_float;
    for (const TargetFormat format : {TargetFormat::rgba16f, TargetFormat::rgba8}) {
      const bool eight_bit = format == TargetFormat::rgba8;
      const Image<float> image = picture(camera, options, format, accurate());
      const Difference d = compare(image, reference, eight_bit);
      const std::string label = name + (eight_bit ? " RGBA8" : " RGBA16F");
      print(label, d);
      EXPECT_GE(d.psnr, eight_bit ? (exact ? 55 : 45) : (exact ? 65 : 50)) << label;
      keep_picture(std::string(host::name(GetParam())) + "_" + label, image);
    }
  }
};

const RenderOptions kRose{.background = {0.9, 0.6, 0.7}};

TEST_P(PictureTest, OneSplat) {
  SplatCloud cloud;
  add(cloud, {.scale = {0.4F, 0.2F, 0.1F}, .color = {1, 0.5F, 0.25F}});
  expect_like_reference("one splat", cloud, front_camera(97, 63, 2));
  expect_like_reference("one splat on rose", cloud, front_camera(97, 63, 2), kRose);
}

// y points down and row 0 is the top: up is where y is small.
TEST_P(PictureTest, IsUpright) {
  SplatCloud cloud;
  add(cloud, {.position = {0.3F, -0.5F, 0}, .color = {0, 1, 0}});
  must(renderer().upload(cloud));
  const Image<float> image = picture(front_camera(80, 80, 2), {}, TargetFormat::rgba8, accurate());
  EXPECT_GT(image.at(52, 20)[1], 0.7F);
  EXPECT_EQ(image.at(52, 60)[1], 0.0F);
  EXPECT_EQ(image.at(28, 20)[1], 0.0F);
  EXPECT_EQ(image.at(52, 20)[0], 0.0F);
  EXPECT_NEAR(image.at(52, 20)[3], 0.8F, 0.02F);
}

TEST_P(PictureTest, TwoOverlapping) {
  SplatCloud cloud;
  add(cloud, {.position = {0.05F, 0, 0.5F}, .color = {0, 0, 1}});
  add(cloud, {.position = {-0.05F, 0, 0}, .color = {1, 0, 0}});
  expect_like_reference("two splats", cloud, front_camera(101, 75, 1.5));
  std::swap(cloud.positions[0], cloud.positions[1]);
  expect_like_reference("two splats, swapped", cloud, front_camera(101, 75, 1.5));
}

TEST_P(PictureTest, Needles) {
  SplatCloud cloud;
  for (int i = 0; i < 12; ++i) {
    const float half_angle = static_cast<float>(std::numbers::pi) * static_cast<float>(i) / 24;
    add(cloud, {.scale = {0.8F, 1e-5F, 1e-5F},
                .rotation = {std::cos(half_angle), 0, 0, std::sin(half_angle)},
                .opacity = 0.9F,
                .color = {1, static_cast<float>(i) / 12, 0}});
  }
  expect_like_reference("needles", cloud, front_camera(200, 150, 1.5));
  cloud.log_scales.assign(12, {std::log(200.0F), std::log(1e-5F), std::log(1e-5F)});
  expect_like_reference("endless needles", cloud, front_camera(200, 150, 1.5));
}

TEST_P(PictureTest, BehindAndAcrossTheNearPlane) {
  SplatCloud cloud;
  add(cloud, {.position = {0, 0, -5}});
  const Camera camera = front_camera(60, 60, 2);
  expect_like_reference("behind the camera", cloud, camera, kRose);
  EXPECT_EQ(must(renderer().stats()).drawn, 0U);
  // Centres on both sides of the near plane at 0.01, bodies across it.
  for (const float z : {-2.2F, -1.995F, -1.9895F, -1.9F, -1.5F})
    add(cloud, {.position = {0.01F, 0.005F, z}, .scale = {0.2F, 0.01F, 0.3F}, .opacity = 0.3F});
  expect_like_reference("across the near plane", cloud, camera, kRose);
  EXPECT_EQ(must(renderer().stats()).drawn, 3U);
}

TEST_P(PictureTest, ThousandCoplanarOfEqualDepth) {
  SplatCloud cloud = random_cloud(1000, 0, 1);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.positions[i] = 0.4F * cloud.positions[i];
    cloud.positions[i].z = 0.125F;
    cloud.log_scales[i] += 1.5F;
    cloud.sh_dc[i] *= 2.0F;
  }
  expect_like_reference("coplanar", cloud, front_camera(160, 120, 1));
}

TEST_P(PictureTest, RandomClouds) {
  for (int degree = 0; degree <= 3; ++degree)
    expect_like_reference("random, degree " + std::to_string(degree), random_cloud(5000, degree, 2),
                          orbit_camera(400, 301, {}, 2, degree, 4), kRose);
  expect_like_reference("inside the cloud", random_cloud(5000, 1, 3),
                        orbit_camera(203, 151, {}, 0.4, 1, 4), kRose);
}

TEST_P(PictureTest, HugeSplats) {
  SplatCloud cloud = random_cloud(50, 0, 4);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.opacity_logits[i] = -1.5F;
    if (i % 2 == 0) cloud.log_scales[i] += static_cast<float>(i);  // up to e⁴⁵ units
  }
  expect_like_reference("huge splats", cloud, front_camera(161, 121, 2), kRose);
}

// From nearly nothing to opaque; long runs of full transmittance loss.
TEST_P(PictureTest, OpaqueWalls) {
  SplatCloud cloud = random_cloud(3000, 0, 5);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.log_scales[i] += 1.0F;
    cloud.opacity_logits[i] = 20.0F;
  }
  expect_like_reference("opaque", cloud, orbit_camera(160, 120, {}, 2, 1, 4));
}

// Nothing hides more than alpha_max of what is behind it.
TEST_P(PictureTest, NoSplatIsFullyOpaque) {
  SplatCloud cloud;
  add(cloud, {.scale = glm::vec3(1e4F), .color = {0, 0, 0}});
  cloud.opacity_logits[0] = 30.0F;
  must(renderer().upload(cloud));
  for (const double alpha_max : {0.99, 0.5, 1.0}) {
    const RenderOptions options{.alpha_max = alpha_max, .background = {1, 1, 1}};
    const Image<float> image =
        picture(front_camera(8, 8, 2), options, TargetFormat::rgba16f, accurate());
    for (std::size_t i = 0; i < image.pixels.size(); i += 4) {
      EXPECT_NEAR(image.pixels[i], 1 - alpha_max, 5e-4);
      EXPECT_NEAR(image.pixels[i + 3], alpha_max, 1e-3);
    }
  }
}

// About 200 faint layers a pixel: what rounding in every layer does. Blended in float32 nothing is
// lost; half floats are good enough where the driver rounds them to the nearest; bytes are not.
TEST_P(PictureTest, Haze) {
  SplatCloud cloud = random_cloud(20'000, 1, 6);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.log_scales[i] += 1.5F;
    cloud.opacity_logits[i] = -3.0F + 0.25F * cloud.opacity_logits[i];
  }
  const Camera camera = orbit_camera(160, 119, {}, 1.6, 1, 4);
  expect_like_reference("haze", cloud, camera, kRose);
  const ReferenceImage reference = render_reference(cloud, camera, kRose);
  struct Way {
    const char* name;
    TargetFormat format;
    Accumulation accumulation;
    double least;  // dB
  };
  const bool truncates = api().quirks.half_float_blending_truncates;
  const double half = truncates ? 39 : 60, half_then_bytes = truncates ? 39 : 55, bytes = 35;
  for (const Way& way :
       {Way{"haze, RGBA16F direct", TargetFormat::rgba16f, Accumulation::direct, half},
        Way{"haze, RGBA8 from RGBA16F", TargetFormat::rgba8, Accumulation::half_float,
            half_then_bytes},
        Way{"haze, RGBA8 direct", TargetFormat::rgba8, Accumulation::direct, bytes}}) {
    const Image<float> image = picture(camera, kRose, way.format, way.accumulation);
    const Difference d = compare(image, reference, way.format == TargetFormat::rgba8);
    print(way.name, d);
    EXPECT_GE(d.psnr, way.least) << way.name;
  }
}

TEST_P(PictureTest, OddSizes) {
  const SplatCloud cloud = random_cloud(500, 0, 7);
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 9}, {17, 1}, {3, 7}, {255, 33}})
    expect_like_reference(std::to_string(width) + "x" + std::to_string(height), cloud,
                          front_camera(width, height, 2), kRose);
}

TEST_P(PictureTest, FarFromTheOrigin) {
  const glm::vec3 centre(1e5F, -2e5F, 3e4F);
  SplatCloud cloud = random_cloud(2000, 1, 8, centre);
  expect_like_reference("far from the origin", cloud,
                        orbit_camera(200, 150, glm::dvec3(centre), 2, 1, 5));
}

TEST_P(PictureTest, NonFiniteSplatsAreNotDrawn) {
  SplatCloud cloud = random_cloud(700, 1, 9);
  const Camera camera = orbit_camera(120, 90, {}, 2, 1, 4);
  const std::array<float, 3> bad = {std::nanf(""), INFINITY, -INFINITY};
  std::size_t i = 0;
  for (const float value : bad) {
    cloud.positions[i++].y = value;
    cloud.log_scales[i++].x = value;
    cloud.rotations[i++].w = value;
    cloud.opacity_logits[i++] = value;
    cloud.sh_dc[i++].b = value;
    cloud.sh_rest[3 * i++ + 1].g = value;
  }
  SplatCloud without = cloud;
  EXPECT_EQ(drop_non_finite(without), i);
  expect_like_reference("non-finite", without, camera, kRose);
  const Image<float> expected = picture(camera, kRose, TargetFormat::rgba16f, accurate());
  must(renderer().upload(cloud));
  const Image<float> image = picture(camera, kRose, TargetFormat::rgba16f, accurate());
  EXPECT_EQ(image.pixels, expected.pixels);
}

// Finite, but beyond what float32 can project: nothing of it may reach the picture as NaN.
TEST_P(PictureTest, AbsurdButFiniteValues) {
  SplatCloud cloud = random_cloud(300, 1, 10);
  std::size_t i = 0;
  for (const float value : {3e38F, -3e38F, 1e20F, 1e14F, -1e14F, 1e-38F}) {
    cloud.positions[i++].z = value;
    cloud.positions[i++].x = value;
    cloud.log_scales[i++].x = value;
    cloud.rotations[i++] = {value, value, value, value};
    cloud.opacity_logits[i++] = value;
    cloud.sh_dc[i++].r = value;
    cloud.sh_rest[3 * i++].g = value;
  }
  must(renderer().upload(cloud));
  for (const TargetFormat format : {TargetFormat::rgba16f, TargetFormat::rgba8}) {
    const Image<float> image =
        picture(orbit_camera(64, 48, {}, 2, 1, 4), kRose, format, accurate());
    EXPECT_TRUE(std::ranges::none_of(image.pixels, [](float v) { return std::isnan(v); }));
  }
}

TEST_P(PictureTest, PlushDog) {
  const SplatCloud cloud = plush_dog();
  if (cloud.size() == 0) GTEST_SKIP() << "FLUXGS_DATA is not set or has no splats/plush-dog";
  for (int i = 0; i < 4; ++i)
    expect_like_reference("plush-dog, view " + std::to_string(i), cloud,
                          orbit_camera(400, 399, mean_position(cloud), 0.35, i, 4));
}

FLUXGS_GL_TEST_SUITE(PictureTest);

}  // namespace
}  // namespace fluxgs::test
