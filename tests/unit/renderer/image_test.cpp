// Whole images against the float64 reference. The numerical hard cases have files of their own.
#include "image_fixture.h"
#include "render/blend_check.h"

namespace fluxgs::test {
namespace {

using render::Accumulation;
using render::RenderTarget;
using render::TargetFormat;

// y points down and row 0 is the top: up is where y is small.
TEST_P(ImageTest, IsUpright) {
  SplatCloud cloud;
  add(cloud, {.position = {0.3F, -0.5F, 0}, .color = {0, 1, 0}});
  must(renderer().upload(cloud));
  const Image<float> image = draw(front_camera(80, 80, 2), {}, TargetFormat::rgba8, accurate());
  EXPECT_GT(image.at(52, 20)[1], 0.7F);
  EXPECT_EQ(image.at(52, 60)[1], 0.0F);
  EXPECT_EQ(image.at(28, 20)[1], 0.0F);
  EXPECT_EQ(image.at(52, 20)[0], 0.0F);
  EXPECT_NEAR(image.at(52, 20)[3], 0.8F, 0.02F);
}

TEST_P(ImageTest, TwoOverlapping) {
  SplatCloud cloud;
  add(cloud, {.position = {0.05F, 0, 0.5F}, .color = {0, 0, 1}});
  add(cloud, {.position = {-0.05F, 0, 0}, .color = {1, 0, 0}});
  expect_like_reference("two splats", cloud, front_camera(101, 75, 1.5));
  std::swap(cloud.positions[0], cloud.positions[1]);
  expect_like_reference("two splats, swapped", cloud, front_camera(101, 75, 1.5));
}

TEST_P(ImageTest, RandomClouds) {
  for (int degree = 0; degree <= 3; ++degree)
    expect_like_reference("random, degree " + std::to_string(degree), random_cloud(5000, degree, 2),
                          orbit_camera(400, 301, {}, 2, degree, 4), kRose);
}

// About 200 low-opacity layers a pixel: what rounding in every layer does. Blended in float32
// nothing is lost; half floats are good enough where the driver rounds them to the nearest; bytes
// are not.
TEST_P(ImageTest, Haze) {
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
    const Image<float> image = draw(camera, kRose, way.format, way.accumulation);
    const Difference d = compare(image, reference, way.format == TargetFormat::rgba8);
    print(way.name, d);
    EXPECT_GE(d.psnr, way.least) << way.name;
  }
}

TEST_P(ImageTest, TruncatedHalfFloatsAreFoundByTrying) {
  EXPECT_EQ(must(render::half_float_blending_truncates(api())),
            api().quirks.half_float_blending_truncates);
}

TEST_P(ImageTest, PlushDog) {
  const SplatCloud cloud = plush_dog();
  if (cloud.size() == 0) GTEST_SKIP() << "FLUXGS_DATA is not set or has no splats/plush-dog";
  for (int i = 0; i < (kSanitized ? 1 : 4); ++i)
    expect_like_reference("plush-dog, view " + std::to_string(i), cloud,
                          orbit_camera(400, 399, mean_position(cloud), 0.35, i, 4));
}

FLUXGS_GL_FORMS_TEST_SUITE(ImageTest);

}  // namespace
}  // namespace fluxgs::test
