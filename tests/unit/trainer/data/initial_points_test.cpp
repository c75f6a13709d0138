// Initial points: from the sparse model, from features, at random.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <glm/geometric.hpp>

#include "support/scenes.h"
#include "test_files.h"
#include "tools/capture/capture.h"
#include "trainer/data/features.h"
#include "trainer/data/initial_points.h"
#include "trainer/data/scene_focus.h"
#include "trainer/data/triangulate_features.h"

namespace fluxgs {
namespace {

using namespace test;

View blank_view(const glm::dvec3& center, const glm::dvec3& target) {
  View view{camera_at(center, target, 64, 48), Image<std::uint8_t>(64, 48, 3), {}};
  view.camera.fx = view.camera.fy = 60;
  std::ranges::fill(view.rgb.pixels, std::uint8_t{51});
  return view;
}

bool shows(const View& view, const glm::dvec3& point) {
  const Camera& c = view.camera;
  const glm::dvec3 p = c.rotation * point + c.translation;
  const double u = c.fx * p.x / p.z + c.cx, v = c.fy * p.y / p.z + c.cy;
  return p.z > 0 && u > -0.01 && u < 64.01 && v > -0.01 && v < 48.01;
}

/// Images of the ray-traced scene, in memory.
Dataset captured(int count) {
  const capture::CaptureOptions options{.width = 320, .height = 240, .train = count, .test = 0};
  const auto scene = capture::make_scene(1);
  Dataset dataset;
  for (const Camera& camera : capture::capture_cameras(options).train)
    dataset.train.push_back({camera, capture::render_view(scene, camera, 2), camera.name});
  return dataset;
}

TEST(InitialPoints, SparsePointsComeFirst) {
  Dataset dataset;
  for (int i = 0; i < 50; ++i) {
    dataset.points.emplace_back(1, 2, i);
    dataset.point_colors.emplace_back(255, 0, 51);
  }
  const auto cloud = initial_points(dataset, 1, Threads(2));
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->source, "sparse points");
  EXPECT_EQ(cloud->positions, dataset.points);
  EXPECT_FLOAT_EQ(cloud->colors[0].z, 0.2F);
}

TEST(InitialPoints, AFewSparsePointsAreNoScene) {
  Dataset dataset = captured(6);
  dataset.points = {{0, 0, 0}};
  dataset.point_colors = {{1, 2, 3}};
  const auto cloud = initial_points(dataset, 1, Threads(2));
  ASSERT_TRUE(cloud);
  EXPECT_GT(cloud->positions.size(), 100U);
  EXPECT_THAT(cloud->source, testing::EndsWith("; 1 sparse points are too few"));
}

TEST(InitialPoints, NothingToSeeIsAnError) {
  expect_failure(initial_points(Dataset{}, 1, Threads(2)), "no training images");
}

TEST(InitialPoints, BlankViewsGetRandomPointsInTheirFrustums) {
  Dataset dataset;
  const glm::dvec3 target(100, 50, -20);
  for (const glm::dvec3& from : {glm::dvec3(5, 1, 0), glm::dvec3(0, -1, 5), glm::dvec3(-4, 2, 1)})
    dataset.train.push_back(blank_view(target + from, target));
  const auto cloud = initial_points(dataset, 7, Threads(2));
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->source, "random; only 0 features of the images fit their poses");
  ASSERT_EQ(cloud->positions.size(), 20'000U);
  ASSERT_EQ(cloud->colors.size(), 20'000U);
  for (const glm::vec3& color : cloud->colors) ASSERT_EQ(color, glm::vec3(0.5F));
  for (const glm::vec3& position : cloud->positions) {
    const bool seen = std::ranges::any_of(dataset.train, [&](const View& view) {
      const Camera& c = view.camera;
      const double z = (c.rotation * glm::dvec3(position) + c.translation).z;
      const double focus = glm::distance(target, c.center());
      return z > 0.39 * focus && z < 2.01 * focus && shows(view, position);
    });
    ASSERT_TRUE(seen);
  }
  EXPECT_EQ(initial_points(dataset, 7, Threads(2))->positions, cloud->positions);
  EXPECT_NE(initial_points(dataset, 8, Threads(2))->positions, cloud->positions);
}

TEST(InitialPoints, RandomPointsLieWhereManyViewsLook) {
  std::vector<View> views;
  for (int i = 0; i < 30; ++i) {
    const double turn = 2 * std::numbers::pi * i / 30;
    views.push_back(blank_view({4 * std::cos(turn), 0, 4 * std::sin(turn)}, {0, 0, 0}));
  }
  const PointCloud cloud = random_points(views, 2000, 5);
  ASSERT_EQ(cloud.positions.size(), 2000U);
  // The median of all points that some view may see is in 20 frames
  for (const glm::vec3& point : cloud.positions)
    ASSERT_GE(std::ranges::count_if(views, [&](const View& v) { return shows(v, point); }), 7);
}

TEST(SceneFocus, IsWhereTheCamerasLook) {
  const glm::dvec3 target(1e5, -2e5, 3e4);  // Far from the world's origin
  std::vector<View> views;
  for (const glm::dvec3& from : {glm::dvec3(3, 1, 0), glm::dvec3(0, 1, 4), glm::dvec3(-5, 1, 1)})
    views.push_back(blank_view(target + from, target));
  const auto distances = focus_distances(views);
  for (std::size_t i = 0; i < views.size(); ++i)
    EXPECT_NEAR(distances[i], glm::distance(views[i].camera.center(), target), 1e-6);
}

TEST(SceneFocus, DegenerateCamerasHaveADistance) {
  const glm::dvec3 ahead(0, 0, 1000);
  // Parallel views: the extent of the positions.
  std::vector<View> parallel;
  for (const double x : {0.0, 1.0, 4.0})
    parallel.push_back(blank_view({x, 0, 0}, glm::dvec3(x, 0, 0) + ahead));
  EXPECT_THAT(focus_distances(parallel), testing::Each(testing::DoubleNear(4, 1e-9)));
  // A panorama looking outward from a circle: the common point is behind every camera.
  std::vector<View> outward;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 d(std::cos(i * 0.785), 0, std::sin(i * 0.785));
    outward.push_back(blank_view(d, 5.0 * d));
  }
  for (const double distance : focus_distances(outward)) EXPECT_GT(distance, 1);
  // One image, and images from one place.
  EXPECT_THAT(focus_distances({parallel[0]}), testing::ElementsAre(1.0));
  EXPECT_THAT(focus_distances({parallel[0], parallel[0]}), testing::Each(1.0));
  EXPECT_EQ(random_points({parallel[0]}, 10, 1).positions.size(), 10U);
}

TEST(Features, LieWhereTheDotsAre) {
  View view = blank_view({0, 0, 0}, {0, 0, 1});
  view.rgb = Image<std::uint8_t>(200, 160, 3);
  std::vector<glm::dvec2> dots;
  for (int i = 0; i < 12; ++i) dots.emplace_back(30.3 + 45.25 * (i % 4), 30.6 + 45.7 * (i / 4));
  for (int y = 0; y < 160; ++y)
    for (int x = 0; x < 200; ++x) {
      double value = 20;
      for (const auto& dot : dots) {
        const glm::dvec2 d = glm::dvec2(x + 0.5, y + 0.5) - dot;
        value += 200 * std::exp(-glm::dot(d, d) / 18);
      }
      std::fill_n(view.rgb.at(x, y), 3, static_cast<std::uint8_t>(std::lround(value)));
    }
  const auto features = find_features(view);
  glm::dvec2 bias(0);
  for (const auto& dot : dots) {
    const auto nearest = std::ranges::min_element(
        features, {}, [&](const Feature& f) { return glm::distance(f.pixel, dot); });
    ASSERT_NE(nearest, features.end());
    EXPECT_LT(glm::distance(nearest->pixel, dot), 0.15);
    bias += nearest->pixel - dot;
  }
  EXPECT_LT(glm::length(bias / 12.0), 0.08);
}

/// The distance from a point to the nearest surface of the ray-traced scene; nothing behind a
/// mirror (inside a sphere, below the floor), where features of mirror images rightly are.
std::optional<double> surface_distance(const capture::Scene& scene, const glm::vec3& p) {
  constexpr double kBehind = -0.1;
  double nearest = std::min<double>(std::abs(p.z), std::abs(p.y - scene.boxes[0].low.y));
  if (p.z < kBehind) return std::nullopt;
  for (const auto& sphere : scene.spheres) {
    const double outside = glm::distance(p, sphere.center) - sphere.radius;
    if (outside < kBehind) return std::nullopt;
    nearest = std::min(nearest, std::abs(outside));
  }
  return nearest;
}

TEST(Triangulation, PointsLieOnTheSurfacesOfAKnownScene) {
  const Dataset dataset = captured(16);
  const auto cloud = initial_points(dataset, 1, Threads(2));
  ASSERT_TRUE(cloud);
  EXPECT_EQ(cloud->source, "triangulated features");
  EXPECT_GT(cloud->positions.size(), 500U);
  const auto scene = capture::make_scene(1);
  std::vector<double> distances;
  for (const glm::vec3& p : cloud->positions)
    if (const auto distance = surface_distance(scene, p)) distances.push_back(*distance);
  EXPECT_GT(distances.size(), cloud->positions.size() / 2);
  // A pixel is 0.015 units wide there, and 0.09 deep at the usual parallax of 10 degrees.
  std::ranges::sort(distances);
  EXPECT_LT(distances[distances.size() / 2], 0.04);
  EXPECT_LT(distances[distances.size() * 85 / 100], 0.1);
}

TEST(Triangulation, IsTheSameForAnyNumberOfThreads) {
  const Dataset dataset = captured(6);
  const PointCloud many = triangulate_features(dataset.train, Threads(4));
  const PointCloud one = triangulate_features(dataset.train, Threads(1));
  EXPECT_GT(one.positions.size(), 50U);
  EXPECT_EQ(one.positions, many.positions);
  EXPECT_EQ(one.colors, many.colors);
}

TEST(Triangulation, PairsHaveUsefulParallax) {
  const glm::dvec3 target(0, 0, 0);
  std::vector<View> views;
  for (const double degrees : {0.0, 0.2, 10.0, 20.0, 180.0}) {
    const double a = degrees * 3.14159265 / 180;
    views.push_back(blank_view({5 * std::sin(a), 0, -5 * std::cos(a)}, target));
  }
  const auto pairs = choose_pairs(views);
  using testing::Pair;
  EXPECT_THAT(pairs,
              testing::ElementsAre(Pair(0, 2), Pair(0, 3), Pair(1, 2), Pair(1, 3), Pair(2, 3)));
  EXPECT_TRUE(choose_pairs({views[0]}).empty());
}

}  // namespace
}  // namespace fluxgs
