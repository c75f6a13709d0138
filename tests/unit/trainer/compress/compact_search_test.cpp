// Searching for a compact scene: what is measured, and whether the search keeps its promise.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include <Eigen/Core>

#include "fluxgs/io/gltf.h"
#include "support/scenes.h"
#include "trainer/compress/compact_search.h"
#include "trainer/compress/compression.h"
#include "trainer/compress/fit_splats.h"
#include "trainer/compress/sh_fit.h"
#include "trainer/compress/shape_hessian.h"
#include "trainer/compress/view_sensitivity.h"
#include "trainer/train/evaluate.h"

namespace fluxgs {
namespace {

std::vector<Camera> some_cameras() {
  return {test::camera_at({0, 0, -4}, {0, 0, 0}, 64, 48),
          test::camera_at({3, -1, -2}, {0, 0, 0}, 64, 48)};
}

/// Splats of low opacity: where opaque ones swap their depth order by rounding, the error jumps by
/// decibels.
SplatCloud transparent_cloud() {
  SplatCloud cloud = test::random_cloud(3000, 1, 4);
  for (float& logit : cloud.opacity_logits) logit -= 3;
  return cloud;
}

/// A scene, its images, and a search of it.
struct Fixture {
  SplatCloud cloud = transparent_cloud();
  Threads threads{1};
  SceneError error{cloud, some_cameras(), {}, threads};
  CompactOptions options{.steps = default_quantization_steps(cloud)};
};

// The camera is inside of the splat
const RenderOptions kEverything{.depth_spread_max = 0};

TEST(SceneError, IsZeroForTheSameSceneAndKnownForAShiftedColour) {
  const Threads threads(1);
  // One splat that fills the view: its colour is that of every pixel, but for α ≤ 0.99
  SplatCloud cloud = test::one_splat({0, 0, 0}, 100, 20, glm::vec3(0));
  const SceneError error(cloud, {test::camera_in_front(16, 12)}, kEverything, threads);
  EXPECT_EQ(*error.mse(cloud), 0);
  cloud.sh_dc[0] = glm::vec3(0.5f, 0, 0);
  const double shift = 0.99 * 0.28209479 * 0.5;
  EXPECT_NEAR(*error.mse(cloud), shift * shift / 3, 1e-5);
  EXPECT_NEAR(psnr_of_mse(0.01), 20, 1e-12);
  EXPECT_TRUE(std::isinf(psnr_of_mse(0)));
}

TEST(SceneError, ColoursBeyondTheDisplayDoNotCount) {
  const Threads threads(1);
  SplatCloud cloud = test::one_splat({0, 0, 0}, 100, 20, glm::vec3(10));
  const SceneError error(cloud, {test::camera_in_front(16, 12)}, kEverything, threads);
  cloud.sh_dc[0] = glm::vec3(20);
  EXPECT_EQ(*error.mse(cloud), 0);
}

// Σ over the splats of Σ α·T is what the images of a grey scene add up to, over the grey.
TEST(SeenSplats, WeightsAddUpToTheImage) {
  const Threads threads(1);
  SplatCloud cloud = test::random_cloud(400, 2, 3);
  const auto cameras = some_cameras();
  const auto weights = view_sensitivity(cameras, cloud, false, {}, threads).weights;
  ASSERT_EQ(weights.size(), cloud.size());
  limit_sh_degree(cloud, 0);
  for (glm::vec3& dc : cloud.sh_dc) dc = glm::vec3(0);  // colour 0.5
  const ViewRenderer render = cpu_view_renderer(cloud, {}, threads);
  double sum = 0;
  for (const Camera& camera : cameras) {
    const auto image = render(camera);
    for (int y = 0; y < image->height(); ++y)
      for (int x = 0; x < image->width(); ++x) sum += 2 * double{image->row(0, y)[x]};
  }
  EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0) / sum, 1, 1e-4);
}

TEST(SeenSplats, HiddenSplatsWeighNextToNothing) {
  const Threads threads(1);
  SplatCloud cloud = test::one_splat({0, 0, 0}, 2, 20);  // opaque
  const SplatCloud behind = test::one_splat({0, 0, 1}, 0.2f, 20);
  cloud.resize(2);
  cloud.positions[1] = behind.positions[0];
  cloud.log_scales[1] = behind.log_scales[0];
  cloud.opacity_logits[1] = 20;
  const auto weights =
      view_sensitivity({test::camera_in_front(32, 32)}, cloud, false, {}, threads).weights;
  EXPECT_LT(weights[1], 0.02f * weights[0]);
  EXPECT_GT(weights[1], 0);
}

TEST(SeenSplats, FactorsAreThoseOfTheDirections) {
  SplatCloud cloud = test::random_cloud(60, 2, 5);
  cloud.positions[0] = {0, 0, -1e4f};  // no view sees it
  const PlanarFloats parameters = to_parameters(cloud, 2);
  const Threads one(1), two(2);
  const ViewWeights views = view_weights(parameters, some_cameras(), {}, one);
  const auto factors = sh_factors(parameters, views, one);
  EXPECT_EQ(factors, sh_factors(parameters, views, two));
  const std::size_t each = sh_factor_size(2);
  ASSERT_EQ(factors.size(), 60 * each);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(9, 9);
    for (Eigen::Index row = 0, at = 0; row < 9; ++row)
      for (Eigen::Index column = 0; column <= row; ++column, ++at)
        factor(row, column) = factors[i * each + static_cast<std::size_t>(at)];
    const SplatViews seen = splat_views(views, parameters, i);
    Eigen::MatrixXd expected = Eigen::MatrixXd::Identity(9, 9);
    if (seen.weight > 0)
      expected = 4 * std::numbers::pi * seen.gram.topLeftCorner(9, 9) + kSphereShare * expected;
    EXPECT_LT((factor * factor.transpose() - expected).cwiseAbs().maxCoeff(), 1e-5) << i;
  }
  EXPECT_EQ(splat_views(views, parameters, 0).weight, 0);
}

/// All pixels and colours of a scene's images, one after the other.
std::vector<double> pixels_of(const SplatCloud& cloud, const Threads& threads) {
  std::vector<double> pixels;
  const ViewRenderer render = cpu_view_renderer(cloud, {}, threads);
  for (const Camera& camera : some_cameras()) {
    const auto image = render(camera);
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < image->height(); ++y)
        for (int x = 0; x < image->width(); ++x) pixels.push_back(double{image->row(c, y)[x]});
  }
  return pixels;
}

/// uᵀ·JᵀJ·u for what `change` does to splat i, by differences.
template <class Change>
double squared_change(const SplatCloud& cloud, const Threads& threads, const Change& change) {
  constexpr float kBy = 4e-3f;
  SplatCloud more = cloud, less = cloud;
  change(more, kBy);
  change(less, -kBy);
  const auto a = pixels_of(more, threads), b = pixels_of(less, threads);
  double sum = 0;
  for (std::size_t p = 0; p < a.size(); ++p) {
    const double by = (a[p] - b[p]) / (2 * double{kBy});
    sum += by * by;
  }
  return sum;
}

/// uᵀ·H·u.
double form(const float* triangle, const glm::dvec3& u) {
  double sum = 0;
  for (int row = 0, at = 0; row < 3; ++row)
    for (int column = 0; column <= row; ++column, ++at)
      sum += (row == column ? 1 : 2) * double{triangle[at]} * u[row] * u[column];
  return sum;
}

// Each is a mean of few random numbers, whose mean over the splats is near.
TEST(ShapeHessian, IsWhatImagesChangeBy) {
  constexpr std::size_t kSplats = 40;
  SplatCloud cloud = test::random_cloud(kSplats, 1, 6);
  for (glm::quat& q : cloud.rotations) q = 2.0f * glm::normalize(q);
  for (std::size_t i = 0; i < kSplats; ++i) {
    cloud.log_scales[i] = glm::vec3(-1.2f, -1.8f, -2.4f);
    cloud.opacity_logits[i] = 0;
  }
  const Threads one(1), two(2);
  const PlanarFloats parameters = to_parameters(cloud, 1);
  const ShapeHessian found = shape_hessian(parameters, some_cameras(), {}, one);
  const ShapeHessian again = shape_hessian(parameters, some_cameras(), {}, two);
  EXPECT_EQ(found.scale, again.scale);
  EXPECT_EQ(found.rotation, again.rotation);
  for (const glm::vec3 u : {glm::vec3(1, 0, 0), glm::vec3(1, 1, 1), glm::vec3(1, -2, 1)}) {
    double scale = 0, rotation = 0, expected_scale = 0, expected_rotation = 0;
    for (std::size_t i = 0; i < kSplats; ++i) {
      scale += form(&found.scale[6 * i], u);
      rotation += form(&found.rotation[6 * i], u);
      expected_scale +=
          squared_change(cloud, one, [&](SplatCloud& c, float by) { c.log_scales[i] += by * u; });
      expected_rotation += squared_change(cloud, one, [&](SplatCloud& c, float by) {
        c.rotations[i] = glm::quat(1, 0.5f * by * u) * c.rotations[i];
      });
    }
    EXPECT_NEAR(scale / expected_scale, 1, 0.15);
    EXPECT_NEAR(rotation / expected_rotation, 1, 0.15);
  }
}

TEST(ShapeHessian, OfWhatNoViewSeesIsNone) {
  SplatCloud cloud = test::random_cloud(3, 1, 6);
  cloud.positions[1] = {0, 0, -1e4f};
  const Threads threads(1);
  const ShapeHessian found = shape_hessian(to_parameters(cloud, 1), some_cameras(), {}, threads);
  for (std::size_t k = 6; k < 12; ++k) {
    EXPECT_EQ(found.scale[k], 0);
    EXPECT_EQ(found.rotation[k], 0);
  }
  EXPECT_TRUE(shape_hessian(to_parameters(cloud, 1), {}, {}, threads).scale.size() == 18);
}

TEST(CompactSearch, StaysWithinTheLossAndUsesIt) {
  const Fixture f;
  const CompactSearch search(f.cloud, f.error, f.options);
  for (const double decibels : {30.0, 45.0}) {
    const auto found = search.within_loss(decibels);
    ASSERT_TRUE(found) << found.error().message();
    EXPECT_GE(found->psnr(), decibels);
    EXPECT_LT(found->psnr(), decibels + 0.3);
    const auto scene = read_glb(found->file, "x");
    ASSERT_TRUE(scene);
    EXPECT_EQ(*f.error.mse(scene->cloud), found->mse);
  }
}

TEST(CompactSearch, ImagesThatShowNothingAreNoReasonForCoarseSteps) {
  Fixture f;
  for (glm::vec3& dc : f.cloud.sh_dc) dc = glm::vec3(-100);  // black on black
  const SceneError error(f.cloud, some_cameras(), {}, f.threads);
  const auto found = CompactSearch(f.cloud, error, f.options).within_loss(40);
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_EQ(found->options.steps.position, f.options.steps.position);
}

TEST(CompactWithin, ProgressEndsAtItsEndAndAStopIsAnError) {
  Fixture f;
  std::vector<std::size_t> done;
  const CompactGoal goal{some_cameras(), {}, 40};
  const auto found = compact_within(f.cloud, f.cloud, goal, f.options, f.threads,
                                    {.progress = [&](std::size_t now, std::size_t total) {
                                      EXPECT_LE(now, total);
                                      done.push_back(now);
                                    }});
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_TRUE(std::ranges::is_sorted(done));
  EXPECT_EQ(done.back(), 1000u);
  EXPECT_GT(done.size(), 12u);

  for (const std::size_t most : {std::size_t{0}, std::size_t{3}, done.size() / 2}) {
    std::size_t reports = 0;
    const auto stopped = compact_within(
        f.cloud, f.cloud, goal, f.options, f.threads,
        {[&](std::size_t, std::size_t) { ++reports; }, [&] { return reports >= most; }});
    EXPECT_FALSE(stopped);
    EXPECT_LE(reports, most + 1);
  }
}

TEST(CompactSearch, StaysWithinTheBytesAndUsesThem) {
  const Fixture f;
  const CompactSearch search(f.cloud, f.error, f.options);
  const auto found = search.within_bytes(25'000);
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_LE(found->file.size(), 25'000u);
  EXPECT_GT(found->file.size(), 24'000u);
}

TEST(CompactSearch, BalancingMakesABadStartBetter) {
  Fixture f;
  f.options.steps.log_scale *= 6;
  f.options.steps.sh_dc /= 6;
  const CompactSearch search(f.cloud, f.error, f.options);
  const auto before = search.trial(f.options.steps);
  ASSERT_TRUE(before);
  const auto after = search.within_bytes(before->file.size());
  ASSERT_TRUE(after) << after.error().message();
  EXPECT_GT(after->psnr(), before->psnr() + 1);
}

// Of degrees 0 and 1 in a cloud of degree 3, whose files have degree 1.
TEST(CompactSearch, SplatsOfSeveralDegrees) {
  const Fixture f;
  SplatCloud cloud = test::random_cloud(1400, 3, 5);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    for (std::size_t k = i % 2 == 0 ? 0 : 3; k < 15; ++k) cloud.sh_rest[15 * i + k] = glm::vec3(0);
  const SceneError error(cloud, some_cameras(), {}, f.threads);
  const CompactOptions options{.steps = default_quantization_steps(cloud)};
  const auto found = CompactSearch(cloud, error, options).within_loss(40);
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_GE(found->psnr(), 40);
  const auto scene = read_glb(found->file, "x");
  ASSERT_TRUE(scene);
  EXPECT_EQ(scene->cloud.sh_degree, 1);
  EXPECT_EQ(*error.mse(scene->cloud), found->mse);
}

TEST(CompactSearch, PlentyOfBytesAreNoError) {
  const Fixture f;
  const auto found = CompactSearch(f.cloud, f.error, f.options).within_bytes(100'000'000);
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_GT(found->psnr(), 80);
}

TEST(CompactSearch, ASplatFarAwayIsNoError) {
  Fixture f;
  f.cloud.positions[0].x = 1e20f;
  const SceneError error(f.cloud, some_cameras(), {}, f.threads);
  const CompactSearch search(f.cloud, error, {.steps = default_quantization_steps(f.cloud)});
  EXPECT_TRUE(search.within_bytes(50'000));
}

TEST(CompactSearch, WhatCannotBeReachedIsSaid) {
  const Fixture f;
  const CompactSearch search(f.cloud, f.error, f.options);
  const auto small = search.within_bytes(1000);
  ASSERT_FALSE(small);
  EXPECT_NE(small.error().message().find("expected 1000 at most"), std::string::npos);
  const auto exact = search.within_loss(119);
  ASSERT_FALSE(exact);
  EXPECT_NE(exact.error().message().find("expected 119"), std::string::npos);
}

}  // namespace
}  // namespace fluxgs
