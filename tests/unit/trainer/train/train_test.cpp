// The training loop: it learns, and gives the same bytes whatever the threads.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "trainer/train/evaluate.h"
#include "unit/trainer/train/short_run.h"

namespace fluxgs {
namespace {

using namespace test;

TEST(Train, LearnsTheScene) {
  const Dataset& data = small_capture();
  TrainOptions options = short_run(800);
  options.densify_until = 600;
  options.opacity_reset_interval = 0;
  const Threads threads(2);
  const auto score = [&](const TrainState& state, const std::vector<Photo>& photos) {
    const SplatCloud cloud = to_cloud(state.parameters, 3);
    return evaluate(photos, cpu_view_renderer(cloud, options.render, threads), threads)->psnr;
  };
  const TrainState start = fresh(data, options);
  const TrainState end = train(data, options, start, 2, 800);
  RecordProperty("train_psnr", std::to_string(score(end, data.train)));
  RecordProperty("test_psnr", std::to_string(score(end, data.test)));
  EXPECT_GT(score(end, data.train), 19.0);
  EXPECT_GT(score(end, data.test), score(start, data.test) + 5.0);  // views it has never seen
}

TEST(Train, SameBytesForAnyNumberOfThreads) {
  const Dataset& data = small_capture();
  const TrainOptions options = short_run(100);
  const TrainState one = train(data, options, fresh(data, options), 1, 100);
  for (int threads : {2, 4})
    expect_same(one, train(data, options, fresh(data, options), threads, 100));
}

TEST(Train, SeedsChangeTheResult) {
  const Dataset& data = small_capture();
  TrainOptions options = short_run(10);
  const TrainState one = train(data, options, fresh(data, options), 2, 10);
  options.seed = 2;
  const TrainState two = train(data, options, fresh(data, options), 2, 10);
  EXPECT_NE(one.view_order, two.view_order);
}

TEST(Train, NonFiniteGradientsAreSkippedAndCounted) {
  const Dataset& data = small_capture();
  const TrainOptions options = short_run(5);
  TrainState state = fresh(data, options);
  // A quaternion this small overflows its own gradient
  for (int c = 0; c < 4; ++c) state.parameters.row(row::rotation + c)[0] = c == 0 ? 1e-38f : 0.0f;
  for (int c = 0; c < 3; ++c) state.parameters.row(row::log_scale + c)[0] = static_cast<float>(c);
  const TrainState after = train(data, options, std::move(state), 2, 5);
  for (int r = 0; r < after.parameters.rows(); ++r)
    for (std::size_t i = 0; i < after.parameters.size(); ++i)
      ASSERT_TRUE(std::isfinite(after.parameters.row(r)[i]));
}

TEST(Train, FoxForAShortWhile) {
  const char* folder = std::getenv("FLUXGS_DATA");
  if (!folder) GTEST_SKIP() << "FLUXGS_DATA is not set: no real photos to train on";
  LoadOptions load;
  load.downscale = 8;
  const auto data = load_dataset(std::filesystem::path(folder) / "fox", load);
  ASSERT_TRUE(data) << data.error().message();
  TrainOptions options;
  options.iterations = 600;
  options.densify_from = 200;
  const Threads threads(2);
  const TrainState state = train(*data, options, fresh(*data, options), 2, 600);
  const auto score =
      evaluate(data->test,
               cpu_view_renderer(to_cloud(state.parameters, 3), options.render, threads), threads);
  ASSERT_TRUE(score);
  RecordProperty("psnr", std::to_string(score->psnr));
  EXPECT_GT(score->psnr, 19.0);
}

}  // namespace
}  // namespace fluxgs
