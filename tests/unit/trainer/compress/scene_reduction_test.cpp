// Fewer splats: which go, and what is lost with them.
#include "trainer/compress/scene_reduction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "fluxgs/io/compact_glb.h"
#include "support/scenes.h"
#include "trainer/compress/compact_search.h"
#include "trainer/compress/scene_error.h"
#include "trainer/compress/size_search.h"
#include "trainer/compress/view_weights.h"

namespace fluxgs {
namespace {

std::vector<Camera> around() {
  std::vector<Camera> cameras;
  for (int i = 0; i < 8; ++i) {
    const double angle = 0.8 * i;
    cameras.push_back(
        test::camera_at({3 * std::sin(angle), -1, -3 * std::cos(angle)}, {0, 0, 0}, 64, 48));
  }
  return cameras;
}

SplatCloud crowded_scene() { return test::random_cloud(600, 1, 4, 0.7F, 0.08F); }

SplatCloud reduced(const SplatCloud& whole, std::size_t count, const ReductionOptions& options,
                   int thread_count = 1) {
  const Threads threads(thread_count);
  SceneReduction reduction(whole, around(), options, threads);
  reduction.reduce(count);
  return reduction.cloud();
}

/// The splats with the largest sums of α·T.
SplatCloud heaviest(const SplatCloud& whole, std::size_t count) {
  const Threads threads(1);
  const ViewWeights seen =
      view_weights(to_parameters(whole, whole.sh_degree), around(), {}, threads);
  std::vector<double> sums(whole.size());
  for (int v = 0; v < seen.weights.rows(); ++v)
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += double{seen.weights.row(v)[i]};
  std::vector<std::uint32_t> order(whole.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::sort(order, std::greater(), [&](std::uint32_t i) { return sums[i]; });
  order.resize(count);
  return in_order(whole, order);
}

double psnr_to(const SplatCloud& whole, const SplatCloud& other) {
  const Threads threads(1);
  const SceneError error(whole, around(), {}, threads);
  return psnr_of_mse(*error.mse(other));
}

TEST(SceneReduction, LosesLessThanTheLightestSplatsWeigh) {
  const SplatCloud whole = crowded_scene();
  const double lightest = psnr_to(whole, heaviest(whole, 300));
  const double removed = psnr_to(whole, reduced(whole, 300, {.passes = 0}));
  const double fitted = psnr_to(whole, reduced(whole, 300, {}));
  EXPECT_GT(removed, lightest + 1);
  EXPECT_GT(fitted, removed + 2);
}

TEST(SceneReduction, WhatNobodySeesGoesFirstAndTheRestKeepsItsOrder) {
  SplatCloud whole = crowded_scene();
  whole.filter = {.dilation = 0.1, .compensated = true};
  const SplatCloud behind = test::one_splat({0, 40, 0}, 5, 6);  // below all cameras
  whole.positions[7] = behind.positions[0];
  whole.log_scales[7] = behind.log_scales[0];
  const SplatCloud rest = reduced(whole, 599, {.passes = 0});
  ASSERT_EQ(rest.size(), 599U);
  EXPECT_EQ(rest.filter, whole.filter);
  for (std::size_t i = 0; i < rest.size(); ++i)
    EXPECT_EQ(rest.positions[i], whole.positions[i < 7 ? i : i + 1]);
}

TEST(SceneReduction, ComesToTheSameOnAnyNumberOfThreads) {
  const SplatCloud whole = crowded_scene();
  const SplatCloud one = reduced(whole, 200, {}), three = reduced(whole, 200, {}, 3);
  EXPECT_EQ(one.positions, three.positions);
  EXPECT_EQ(one.opacity_logits, three.opacity_logits);
  EXPECT_EQ(one.sh_rest, three.sh_rest);
}

TEST(SceneReduction, CountsItsWorkAndStops) {
  const Threads threads(1);
  SceneReduction reduction(crowded_scene(), around(), {}, threads);
  reduction.reduce(600);
  reduction.reduce(100000);
  EXPECT_EQ(reduction.cloud().positions, crowded_scene().positions);
  std::size_t last = 0, all = 0;
  reduction.reduce(300, {.progress = [&](std::size_t done, std::size_t total) {
                     EXPECT_EQ(done, last + 1);
                     last = done, all = total;
                   }});
  EXPECT_EQ(last, all);
  EXPECT_EQ(reduction.size(), 300U);
  reduction.reduce(100, {.stop = [] { return true; }});
  EXPECT_EQ(reduction.size(), 300U);
  reduction.reduce(1);
  EXPECT_EQ(reduction.size(), 1U);
}

TEST(SizeSearch, TakesFewerSplatsWhereTheyLeaveMoreBits) {
  const SplatCloud whole = crowded_scene();
  const Threads threads(1);
  const SceneError error(whole, around(), {}, threads);
  const CompactOptions start{.steps = default_quantization_steps(whole)};
  constexpr std::size_t kBytes = 4500;
  const auto alone = CompactSearch(whole, error, start).within_bytes(kBytes);
  ASSERT_TRUE(alone) << alone.error().what;
  SceneReduction reduction(whole, around(), {}, threads);
  const auto sized = splats_within_bytes(reduction, error, start, {.bytes = kBytes});
  ASSERT_TRUE(sized) << sized.error().what;
  EXPECT_LT(sized->cloud.size(), whole.size());
  EXPECT_LT(sized->mse, alone->mse);
  const auto again = CompactSearch(sized->cloud, error, start).trial(sized->steps);
  ASSERT_TRUE(again);
  EXPECT_LE(again->file.size(), kBytes);
  EXPECT_EQ(again->mse, sized->mse);
}

TEST(SizeSearch, RefusesASizeThatNothingHas) {
  const SplatCloud whole = crowded_scene();
  const Threads threads(1);
  const SceneError error(whole, around(), {}, threads);
  SceneReduction reduction(whole, around(), {}, threads);
  const CompactOptions start{.steps = default_quantization_steps(whole)};
  const auto none = splats_within_bytes(reduction, error, start, {.bytes = 100});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().field, "size");
  EXPECT_FALSE(splats_within_bytes(reduction, error, start, {.bytes = 100000},
                                   {.stop = [] { return true; }}));
}

}  // namespace
}  // namespace fluxgs
