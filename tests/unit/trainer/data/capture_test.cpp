// The project's own capture: what is written is what the loader reads.
#include <algorithm>
#include <ranges>

#include <tbb/global_control.h>
#include <glm/common.hpp>
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

TEST(Capture, PointsLieOnTheSurfacesAndShowTheirColours) {
  const TempFolder folder;
  CaptureOptions options = kSmall;
  options.points = 300;
  ASSERT_TRUE(write_capture(folder.path(), options));
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  ASSERT_EQ(data->points.size(), 300U);
  const Scene scene = make_scene(1);
  std::size_t seen = 0, alike = 0,
              by_chance = 0;  // of those that some training view sees where it projects
  for (std::size_t i = 0; i < data->points.size(); ++i)
    for (const View& view : data->train) {
      const glm::vec3 origin(view.camera.center()), towards = data->points[i] - origin;
      const auto hit = intersect(scene, origin, glm::normalize(towards));
      if (!hit || glm::distance(hit->position, data->points[i]) > 1e-3F * glm::length(towards))
        continue;
      const glm::dvec3 p =
          view.camera.rotation * glm::dvec3(data->points[i]) + view.camera.translation;
      const int x = static_cast<int>(view.camera.fx * p.x / p.z + view.camera.cx);
      const int y = static_cast<int>(view.camera.fy * p.y / p.z + view.camera.cy);
      if (p.z <= 0 || x < 0 || y < 0 || x >= view.rgb.width || y >= view.rgb.height) continue;
      const auto difference = [&](std::size_t point) {
        int sum = 0;
        for (int c = 0; c < 3; ++c)
          sum += std::abs(view.rgb.at(x, y)[c] - data->point_colors[point][c]);
        return sum;
      };
      ++seen, alike += difference(i) < 60, by_chance += difference((i + 1) % 300) < 60;
      break;
    }
  EXPECT_EQ(seen, 300U);
  // Reflections differ from view to view, and fine texture within a pixel
  EXPECT_GT(alike, 150U);
  EXPECT_GT(alike, by_chance + 50);
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

class CaptureScenes : public testing::TestWithParam<SceneKind> {
 protected:
  static CaptureOptions options(std::uint64_t seed) {
    CaptureOptions options = kSmall;
    options.scene = GetParam();
    options.train = 24;
    options.seed = seed;
    return options;
  }
  static std::vector<Camera> cameras(std::uint64_t seed) {
    CaptureCameras all = capture_cameras(options(seed));
    all.train.insert(all.train.end(), all.test.begin(), all.test.end());
    return all.train;
  }
};

/// The part of a view's pixels that show a surface, not the sky.
double surface_part(const Scene& scene, const Camera& camera) {
  int surfaces = 0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const glm::dvec3 pixel((x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy,
                             1);
      const glm::vec3 direction(glm::normalize(glm::transpose(camera.rotation) * pixel));
      surfaces += intersect(scene, glm::vec3(camera.center()), direction).has_value();
    }
  return surfaces / static_cast<double>(camera.width * camera.height);
}

TEST_P(CaptureScenes, EveryCameraSeesSurfacesAndSomethingOnThem) {
  const Scene scene = make_scene(1, GetParam());
  for (const Camera& camera : cameras(1)) {
    EXPECT_GT(surface_part(scene, camera), 0.2) << camera.name;
    const auto image = render_view(scene, camera, 1);
    const auto [low, high] = std::ranges::minmax(image.pixels);
    EXPECT_GT(high - low, 20) << camera.name;
  }
}

TEST_P(CaptureScenes, CamerasStandInFreeSpace) {
  const Scene scene = make_scene(1, GetParam());
  for (const Camera& camera : cameras(1)) {
    const glm::vec3 place(camera.center());
    for (const Sphere& sphere : scene.spheres)
      EXPECT_GT(glm::distance(place, sphere.center), sphere.radius + 0.2F) << camera.name;
    for (const Box& box : scene.boxes)
      EXPECT_GT(glm::distance(place, glm::clamp(place, box.low, box.high)), 0.2F) << camera.name;
  }
}

TEST_P(CaptureScenes, PosesAndImagesAreThoseOfTheSeed) {
  const auto once = cameras(3), again = cameras(3), other = cameras(4);
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].center(), again[i].center());
    EXPECT_EQ(once[i].rotation, again[i].rotation);
    EXPECT_NE(once[i].center(), other[i].center());
  }
  const auto view = [&](std::uint32_t seed) {
    return render_view(make_scene(seed, GetParam()), once[0], 1).pixels;
  };
  EXPECT_EQ(view(3), view(3));
  EXPECT_NE(view(3), view(4));
}

TEST_P(CaptureScenes, IsWhatIsWritten) {
  const TempFolder folder;
  CaptureOptions few = options(1);
  few.train = few.test = 1;
  ASSERT_TRUE(write_capture(folder.path(), few));
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(
      data->train[0].rgb.pixels,
      render_view(make_scene(1, GetParam()), capture_cameras(few).train[0], few.samples).pixels);
}

INSTANTIATE_TEST_SUITE_P(All, CaptureScenes,
                         testing::Values(SceneKind::kSpheres, SceneKind::kOutdoor, SceneKind::kRoom,
                                         SceneKind::kWall));

TEST(Capture, TheSpheresStayAsTheyAre) {
  // Published results are of these images. A view's mean colours, before there were other scenes.
  const auto image = render_view(make_scene(1), capture_cameras(kSmall).train[0], 2);
  double sums[3] = {0, 0, 0};
  for (std::size_t i = 0; i < image.pixels.size(); ++i) sums[i % 3] += image.pixels[i];
  const double pixels = 64 * 48, means[] = {163.430, 162.508, 163.036};
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sums[c] / pixels, means[c], 0.1);
}

TEST(Capture, RaysMeetTheFacesOfBoxes) {
  Scene scene;
  scene.boxes = {{{1, -1, 0}, {2, 1, 3}, {}}, {{-4, -1, 0}, {-4, 1, 3}, {}}};
  const auto from_left = intersect(scene, {0, 0, 1}, {1, 0, 0});
  ASSERT_TRUE(from_left);
  EXPECT_EQ(from_left->distance, 1);
  EXPECT_EQ(from_left->normal, glm::vec3(-1, 0, 0));
  const auto from_above = intersect(scene, {1.5F, 0.5F, 5}, {0, 0, -1});
  ASSERT_TRUE(from_above);
  EXPECT_EQ(from_above->position, glm::vec3(1.5F, 0.5F, 3));
  EXPECT_EQ(from_above->normal, glm::vec3(0, 0, 1));
  const auto rectangle = intersect(scene, {0, 0, 1}, {-1, 0, 0});
  ASSERT_TRUE(rectangle);
  EXPECT_EQ(rectangle->distance, 4);
  EXPECT_FALSE(intersect(scene, {0, 2, 1}, {1, 0, 0}));
  EXPECT_FALSE(intersect(scene, {3, 0, 1}, {1, 0, 0}));
}

TEST(Capture, BoxesKeepLightFromWhatIsBehindThem) {
  Scene scene;
  scene.boxes = {{{1, -1, 0}, {2, 1, 3}, {}}};
  EXPECT_EQ(light_visibility(scene, {0, 0, 1}, {1, 0, 0}, 0.1F), 0);
  EXPECT_EQ(light_visibility(scene, {0, 0, 1}, {-1, 0, 0}, 0.1F), 1);
  EXPECT_EQ(light_visibility(scene, {2, 0, 1}, {1, 0, 0}, 0.1F), 1);
  scene.boxes[0].shades = false;
  EXPECT_EQ(light_visibility(scene, {0, 0, 1}, {1, 0, 0}, 0.1F), 1);
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
