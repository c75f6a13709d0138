// The project's own capture: what is written is what the loader reads.
#include <algorithm>

#include <tbb/global_control.h>
#include <glm/geometric.hpp>

#include "test_files.h"
#include "tools/capture/capture.h"
#include "trainer/data/dataset.h"

namespace fluxgs::capture {
namespace {

using namespace fluxgs::test;

const CaptureOptions kSmall{.width = 64, .height = 48, .train = 5, .test = 2, .samples = 2};

TEST(Capture, RoundTrip) {
  const TempFolder folder;
  const auto written = write_capture(folder.path() / "new" / "folder", kSmall);
  ASSERT_TRUE(written) << written.error().message();
  const auto data = load_dataset(folder.path() / "new" / "folder", {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_TRUE(data->warnings.empty());
  const auto cameras = capture_cameras(kSmall);
  ASSERT_EQ(data->train.size(), 5U);
  ASSERT_EQ(data->test.size(), 2U);
  const Scene scene = make_scene(1);
  for (const auto& [views, made] :
       {std::pair(&data->train, &cameras.train), std::pair(&data->test, &cameras.test)})
    for (std::size_t i = 0; i < made->size(); ++i) {
      const Camera &a = (*views)[i].camera, &b = (*made)[i];
      EXPECT_EQ(a.name, b.name + ".png");
      EXPECT_NEAR(a.fx, b.fx, 1e-12);
      EXPECT_NEAR(a.cy, b.cy, 1e-12);
      EXPECT_LT(glm::distance(a.center(), b.center()), 1e-12);
      EXPECT_LT(glm::distance(a.forward(), b.forward()), 1e-12);
      EXPECT_LT(glm::distance(a.rotation[0], b.rotation[0]), 1e-12);
      EXPECT_EQ((*views)[i].rgb.pixels, render_view(scene, b, kSmall.samples).pixels);
    }
}

TEST(Capture, MasksCoverTheOccluderAndNothingElse) {
  const TempFolder folder, bare;
  CaptureOptions options = kSmall;
  ASSERT_TRUE(write_capture(bare.path(), options));
  options.occluder = true;
  ASSERT_TRUE(write_capture(folder.path(), options));
  const auto data = load_dataset(folder.path(), {}), without = load_dataset(bare.path(), {});
  ASSERT_TRUE(data && without);
  double masked = 0, changed = 0;
  for (std::size_t i = 0; i < data->train.size(); ++i) {
    const View &view = data->train[i], &clean = without->train[i];
    ASSERT_FALSE(view.used.pixels.empty());
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 64; ++x) {
        const bool ignored = *view.used.at(x, y) == 0;
        int difference = 0;
        for (int c = 0; c < 3; ++c)
          difference = std::max(difference, std::abs(view.rgb.at(x, y)[c] - clean.rgb.at(x, y)[c]));
        masked += ignored;
        changed += !ignored && difference > 60;  // shadows and reflections are less
      }
  }
  const double pixels = 5 * 64 * 48;
  EXPECT_GT(masked, 0.04 * pixels);
  EXPECT_LT(masked, 0.3 * pixels);
  EXPECT_LT(changed, 0.01 * pixels);
  for (const View& view : data->test) EXPECT_TRUE(view.used.pixels.empty());
}

TEST(Capture, SpheresAreWhereTheCamerasSayAndUpIsUp) {
  const Scene scene = make_scene(1);
  for (const Camera& camera : capture_cameras(kSmall).train) {
    const auto project = [&](const glm::vec3& p) {
      const glm::dvec3 q = camera.rotation * glm::dvec3(p) + camera.translation;
      return glm::dvec2(camera.fx * q.x / q.z + camera.cx, camera.fy * q.y / q.z + camera.cy);
    };
    const auto image = render_view(scene, camera, 1);
    // The red ball: its pixel is red, unless something stands in front of it.
    const Sphere& red = scene.spheres[1];
    const glm::vec3 origin(camera.center());
    const auto hit = intersect(scene, origin, glm::normalize(red.center - origin));
    ASSERT_TRUE(hit);
    const glm::dvec2 place = project(red.center);
    const bool inside = place.x > 1 && place.y > 1 && place.x < 63 && place.y < 47;
    if (hit->material == &red.material && inside) {
      const std::uint8_t* rgb = image.at(static_cast<int>(place.x), static_cast<int>(place.y));
      EXPECT_GT(rgb[0], rgb[1] + 60);
    }
    EXPECT_LT(project(red.center + glm::vec3(0, 0, 0.3F)).y, place.y) << "up is up";
    EXPECT_NEAR(glm::determinant(camera.rotation), 1, 1e-12);
  }
}

TEST(Capture, SeedsAndThreads) {
  const Scene scene = make_scene(1);
  const Camera camera = capture_cameras(kSmall).train[0];
  const auto many = render_view(scene, camera, 2);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(render_view(scene, camera, 2).pixels, many.pixels);
  EXPECT_NE(render_view(make_scene(2), camera, 2).pixels, many.pixels);
  CaptureOptions other = kSmall;
  other.seed = 2;
  EXPECT_NE(capture_cameras(other).train[0].center(), camera.center());
}

TEST(Capture, FewSamplesApproachMany) {
  // The samples of a pixel are skipped only where nobody sees it.
  const Scene scene = make_scene(1);
  const Camera camera = capture_cameras(kSmall).train[1];
  const auto fine = render_view(scene, camera, 8), standard = render_view(scene, camera, 4);
  double sum = 0;
  for (std::size_t i = 0; i < fine.pixels.size(); ++i)
    sum += std::pow(int{fine.pixels[i]} - int{standard.pixels[i]}, 2);
  const double psnr =
      10 * std::log10(255.0 * 255.0 * static_cast<double>(fine.pixels.size()) / sum);
  EXPECT_GT(psnr, 36);
}

TEST(CaptureBadInput, OptionsAndFolders) {
  const TempFolder folder;
  CaptureOptions bad = kSmall;
  bad.width = 0;
  expect_failure(write_capture(folder.path(), bad), "width", "expected 1 to 8192");
  bad = kSmall;
  bad.samples = 17;
  expect_failure(write_capture(folder.path(), bad), "samples");
  bad = kSmall;
  bad.train = 0;
  expect_failure(write_capture(folder.path(), bad), "train");
  EXPECT_TRUE(fs::is_empty(folder.path()));
  write_text(folder.path() / "file", "x");
  expect_failure(write_capture(folder.path() / "file", kSmall), "file");
}

TEST(Capture, NoTestViewsMeansNone) {
  const TempFolder folder;
  CaptureOptions options = kSmall;
  options.test = 0;
  ASSERT_TRUE(write_capture(folder.path(), options));
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size(), 5U);
  EXPECT_TRUE(data->test.empty());
}

}  // namespace
}  // namespace fluxgs::capture
