// Real image sets, where FLUXGS_DATA names the folder that holds them.
#include <algorithm>
#include <unordered_map>

#include <glm/geometric.hpp>

#include "test_files.h"
#include "trainer/data/colmap_model.h"
#include "trainer/data/dataset.h"
#include "trainer/data/initial_points.h"

namespace fluxgs {
namespace {

using namespace test;

class RealData : public testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("FLUXGS_DATA");
    if (!folder) GTEST_SKIP() << "set FLUXGS_DATA to a folder with fox, snowmiku, banana, chesscat";
    folder_ = folder;
  }

  fs::path need(const char* name) const { return folder_ / name; }

  fs::path folder_;
};

#define NEED(name) \
  if (!fs::exists(need(name))) GTEST_SKIP() << need(name) << " is not there"

TEST_F(RealData, Fox) {
  NEED("fox");
  const auto data = load_dataset(need("fox"), {.downscale = 2});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size(), 43U);
  EXPECT_EQ(data->test.size(), 7U);
  EXPECT_EQ(data->skipped_images, 17U);
  EXPECT_EQ(data->warnings.size(), 1U);
  EXPECT_EQ(data->train[0].camera.width, 225);
  EXPECT_EQ(data->train[0].camera.height, 400);
  // Mutual matches near each other's epipolar lines that intersect in front of every camera and
  // reproject within 2 px exist in numbers only if poses and lens were read rightly.
  const auto cloud = initial_points(*data, 1, Threads(2));
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->source, "triangulated features");
  EXPECT_GT(cloud->positions.size(), 1500U);
}

TEST_F(RealData, ChessCat) {
  NEED("chesscat");
  const auto data = load_dataset(need("chesscat"), {.background = glm::vec3(1)});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size(), 60U);
  EXPECT_EQ(data->test.size(), 20U);
  EXPECT_EQ(data->train[0].rgb.channels, 3);
  EXPECT_EQ(data->train[0].rgb.pixels[0], 255) << "the corner is transparent";
}

/// The mean distance, over all observations, between a sparse point's projection through the loaded
/// camera and the pixel where COLMAP saw it.
double mean_reprojection(const Dataset& data, const ColmapModel& model) {
  std::unordered_map<std::int64_t, glm::dvec3> points;
  for (const auto& p : model.points) points[static_cast<std::int64_t>(p.id)] = p.position;
  std::unordered_map<std::string, const Camera*> cameras;
  for (const auto* views : {&data.train, &data.test})
    for (const View& view : *views) cameras[view.camera.name] = &view.camera;
  double sum = 0, count = 0;
  for (const auto& image : model.images) {
    const Camera& c = *cameras.at(image.name);
    for (const auto& o : image.observations) {
      if (o.point_id < 0) continue;
      const glm::dvec3 p = c.rotation * points.at(o.point_id) + c.translation;
      EXPECT_GT(p.z, 0);
      sum += glm::distance(o.pixel, glm::dvec2(c.fx * p.x / p.z + c.cx, c.fy * p.y / p.z + c.cy));
      count += 1;
    }
  }
  return sum / count;
}

TEST_F(RealData, SnowMiku) {
  NEED("snowmiku");
  const auto data = load_dataset(need("snowmiku"), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size() + data->test.size(), 97U);
  EXPECT_EQ(data->test.size(), 13U);
  EXPECT_EQ(data->points.size(), 23'778U);
  const auto model = read_colmap_model(need("snowmiku") / "sparse" / "0");
  ASSERT_TRUE(model);
  const double mean = mean_reprojection(*data, *model);
  EXPECT_LT(mean, 1.0);
  EXPECT_GT(mean, 0.1) << "the published mean is 0.56 px";
}

TEST_F(RealData, Banana) {
  NEED("banana");
  const auto data = load_dataset(need("banana"), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size() + data->test.size(), 14U);
  EXPECT_EQ(data->points.size(), 6'229U);
  const auto model = read_colmap_model(need("banana") / "sparse" / "0");
  ASSERT_TRUE(model);
  EXPECT_LT(mean_reprojection(*data, *model), 0.4);
}

TEST_F(RealData, TriangulatedFeaturesAgreeWithColmapsPoints) {
  NEED("banana");
  auto data = load_dataset(need("banana"), {});
  ASSERT_TRUE(data) << data.error().message();
  const auto sparse = std::exchange(data->points, {});
  const auto cloud = initial_points(*data, 1, Threads(2));
  ASSERT_TRUE(cloud);
  ASSERT_EQ(cloud->source, "triangulated features");
  EXPECT_GT(cloud->positions.size(), 2000U);
  // The nearest of COLMAP's points, relative to the distance from a camera.
  const glm::vec3 eye(data->train[0].camera.center());
  std::vector<float> relative;
  for (const glm::vec3& p : cloud->positions) {
    float nearest = std::numeric_limits<float>::max();
    for (const glm::vec3& q : sparse) nearest = std::min(nearest, glm::distance(p, q));
    relative.push_back(nearest / glm::distance(p, eye));
  }
  std::ranges::sort(relative);
  EXPECT_LT(relative[relative.size() / 2], 0.005F);
  EXPECT_LT(relative[relative.size() * 9 / 10], 0.02F);
}

}  // namespace
}  // namespace fluxgs
