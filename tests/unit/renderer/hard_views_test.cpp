// Views that break renderers, against the float64 reference, and a scene as large as phones get.
// Splats that do: hard_cases_test.cpp. The tolerance is that of ImageTest::expect_like() unless a
// test says otherwise.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "image_fixture.h"

namespace fluxgs::test {
namespace {

class HardViewsTest : public ImageTest {};

TEST_P(HardViewsTest, CameraInsideTheCloud) {
  const SplatCloud cloud = random_cloud(5000, 1, 3);
  expect_like_reference("inside the cloud", cloud, orbit_camera(203, 151, {}, 0.4, 1, 4), kRose);
  // At the very centre of a splat, and just so far that the near plane leaves it in the image
  const glm::dvec3 at(cloud.positions[7]);
  expect_like_reference("at a splat", cloud, orbit_camera(120, 90, at, 0, 1, 5), kRose);
  expect_like_reference("close to a splat", cloud, orbit_camera(120, 90, at, 0.0101, 1, 5), kRose);
}

// A floor of flat splats, seen from `height` above it: 0 is in the floor itself. Turned so that no
// axis of the world lies in it, or no number would be rounded.
SplatCloud flat_floor(const glm::quat& turn) {
  SplatCloud cloud = random_cloud(3000, 0, 21);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    glm::vec3 p = cloud.positions[i];
    p.y = 0;
    cloud.positions[i] = turn * p;
    cloud.log_scales[i] = {-3.0F, -14.0F, -3.5F};
    cloud.rotations[i] = turn;
  }
  return cloud;
}

Camera above_floor(const glm::quat& turn, double height) {
  Camera camera = front_camera(160, 120, 0);
  const glm::dmat3 world = glm::mat3_cast(glm::dquat(turn));
  const glm::dvec3 eye = world * glm::dvec3(0.1, -height, -1.5);  // y is down
  camera.rotation = glm::transpose(world);
  camera.translation = -(camera.rotation * eye);
  return camera;
}

TEST_P(HardViewsTest, PlaneOfSplatsSeenEdgeOnAndFromWithin) {
  const glm::quat turn = glm::normalize(glm::quat(0.8F, 0.3F, -0.4F, 0.2F));
  const SplatCloud cloud = flat_floor(turn);
  const Camera within = above_floor(turn, 0);
  expect_like_reference("edge-on, in the plane", cloud, within, kRose);
  for (const double height : {1e-6, 1e-3, 0.05})
    expect_like_reference("edge-on, " + std::to_string(height).substr(0, 8) + " above", cloud,
                          above_floor(turn, height), kRose);
}

TEST_P(HardViewsTest, ZeroOneAndOddSizes) {
  for (const auto& [width, height] : {std::pair{0, 0}, {0, 5}, {5, 0}}) {
    const auto target = RenderTarget::create(api(), width, height, TargetFormat::rgba8);
    ASSERT_FALSE(target);
    EXPECT_THAT(target.error().message(), testing::HasSubstr("1×1 to "));
  }
  const SplatCloud cloud = random_cloud(500, 0, 7);
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 9}, {17, 1}, {3, 7}, {255, 33}})
    expect_like_reference(std::to_string(width) + "x" + std::to_string(height), cloud,
                          front_camera(width, height, 2), kRose);
}

TEST_P(HardViewsTest, ExtremeAspectsAndPrincipalPoints) {
  const SplatCloud cloud = random_cloud(1500, 1, 22);
  const auto view = [](int width, int height, double fx, double fy, double cx, double cy,
                       double distance = 2) {
    Camera camera = orbit_camera(width, height, {}, distance, 1, 5);
    camera.fx = fx;
    camera.fy = fy;
    camera.cx = cx;
    camera.cy = cy;
    return camera;
  };
  expect_like_reference("2000x3", cloud, view(2000, 3, 1800, 1800, 1000, 1.5), kRose);
  expect_like_reference("2x1500", cloud, view(2, 1500, 1400, 1400, 1, 750), kRose);
  expect_like_reference("fx = 8 fy", cloud, view(300, 80, 640, 80, 150, 40), kRose);
  expect_like_reference("fy = 8 fx", cloud, view(80, 300, 80, 640, 40, 150), kRose);
  expect_like_reference("centre at a corner", cloud, view(150, 110, 120, 130, 0, 110), kRose);
  expect_like_reference("centre outside", cloud, view(150, 110, 120, 130, -20.3, 130.7), kRose);
  expect_like_reference("5 by 4 degrees", cloud, view(150, 110, 1500, 1500, 75, 55), kRose);
  expect_like_reference("172 by 170 degrees", cloud, view(150, 110, 5, 5, 75, 55, 0.3), kRose);
}

// The same view from a camera that was turned about its axis, so that the image turns by `angle`
// (from x to y). For the right angles the numbers are exact.
Camera rolled(Camera camera, double cosine, double sine) {
  const glm::dmat3 turn(cosine, sine, 0, -sine, cosine, 0, 0, 0, 1);
  camera.rotation = turn * camera.rotation;
  camera.translation = turn * camera.translation;
  return camera;
}

Camera quarter_turn(const Camera& camera) {
  Camera turned = rolled(camera, 0, 1);
  turned.width = camera.height;
  turned.height = camera.width;
  turned.fx = camera.fy;
  turned.fy = camera.fx;
  turned.cx = camera.height - camera.cy;
  turned.cy = camera.cx;
  return turned;
}

Image<float> quarter_turn(const Image<float>& image) {
  Image<float> turned(image.height, image.width, image.channels);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      std::copy_n(image.at(x, y), image.channels, turned.at(image.height - 1 - y, x));
  return turned;
}

Difference between(const Image<float>& a, const Image<float>& b) {
  double sum = 0, greatest = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const double error = static_cast<double>(a.pixels[i]) - static_cast<double>(b.pixels[i]);
    sum += error * error;
    greatest = std::max(greatest, std::abs(error));
  }
  return {-10 * std::log10(sum / static_cast<double>(a.pixels.size())), greatest};
}

// The image turns with the camera. Tolerance between a turned image and the image of the
// turned camera: 80 dB, and one splat at its cut-off, for the footprint's factor is not symmetric
// in x and y.
TEST_P(HardViewsTest, ARolledCameraTurnsTheImage) {
  const SplatCloud cloud = random_cloud(3000, 1, 23);
  Camera camera = orbit_camera(150, 110, {}, 1.8, 1, 5);
  camera.fx = 140;
  camera.cx = 60.25;
  must(renderer().upload(cloud));
  const Camera upright = camera;
  Image<float> expected = draw(camera, kRose, TargetFormat::rgba16f, accurate());
  for (const char* label : {"rolled by 90", "rolled by 180", "rolled by 270"}) {
    camera = quarter_turn(camera);
    expected = quarter_turn(expected);
    const Image<float> image = draw(camera, kRose, TargetFormat::rgba16f, accurate());
    const Difference d = between(image, expected);
    print(label, d);
    EXPECT_GE(d.psnr, 80) << label;
    EXPECT_LE(d.greatest, 1.5 / 255) << label;
  }
  for (const double angle : {0.3, 2.0, 4.4})
    expect_like_reference("rolled by " + std::to_string(angle).substr(0, 3) + " radians", cloud,
                          rolled(upright, std::cos(angle), std::sin(angle)), kRose);
}

// Every splat once, the farthest first. Tolerance: the rounding of a depth in float32.
void expect_sorted(const std::vector<std::uint32_t>& order, const SplatCloud& cloud,
                   const Camera& camera) {
  std::vector<bool> seen(cloud.size());
  double before = std::numeric_limits<double>::infinity(), greatest = 0;
  for (const std::uint32_t splat : order) {
    ASSERT_LT(splat, cloud.size());
    ASSERT_FALSE(seen[splat]) << splat;
    seen[splat] = true;
    const double depth =
        (camera.rotation * glm::dvec3(cloud.positions[splat]) + camera.translation).z;
    greatest = std::max(greatest, depth - before);
    before = depth;
  }
  std::printf("        depths out of order by %.2e at most\n", greatest);
  EXPECT_LE(greatest, 1e-6);
}

// In a small image, for the reference's sake.
TEST_P(HardViewsTest, AMillionSplats) {
  constexpr std::size_t kCount = 1'000'000;
  SplatCloud cloud = random_cloud(kCount, 0, 24);
  std::size_t visible = 0;
  for (std::size_t i = 0; i < kCount; ++i) {
    cloud.log_scales[i] -= 1.0F;
    cloud.opacity_logits[i] = -1.0F + 0.5F * cloud.opacity_logits[i];
    visible += 1 / (1 + std::exp(-static_cast<double>(cloud.opacity_logits[i]))) >= 1.0 / 255;
  }
  const Camera camera = orbit_camera(128, 96, {}, 3, 1, 5);  // All are inside the image
  must(renderer().upload(cloud));
  expect_like("a million splats", render_reference(cloud, camera, kRose), camera, kRose,
              TargetFormat::rgba16f);
  if (!GetParam().has_compute()) return;  // the order holds all, and only the processor can read it
  const std::uint32_t drawn = must(renderer().stats()).drawn;
  EXPECT_NEAR(drawn, static_cast<double>(visible), 2);  // An opacity at the cut-off
  expect_sorted(must(renderer().sorter().order().read_all<std::uint32_t>(drawn)), cloud, camera);
}

FLUXGS_GL_FORMS_TEST_SUITE(HardViewsTest);

}  // namespace
}  // namespace fluxgs::test
