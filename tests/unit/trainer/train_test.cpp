// The training loop: it learns, gives the same bytes whatever the threads, and resumes exactly.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>

#include "fluxgs/io/file.h"
#include "support/temp_folder.h"
#include "tools/capture/capture.h"
#include "trainer/train/checkpoint.h"
#include "trainer/train/evaluate.h"
#include "trainer/train/trainer.h"

namespace fluxgs {
namespace {

/// A capture of the analytic scene, made once.
const Dataset& small_capture() {
  static const Dataset data = [] {
    const test::TempFolder folder;
    capture::CaptureOptions options;
    options.width = 80, options.height = 60, options.train = 16, options.test = 3,
    options.samples = 2;
    if (auto made = capture::write_capture(folder.path(), options); !made)
      throw std::runtime_error(made.error().message());
    auto loaded = load_dataset(folder.path(), {});
    if (!loaded) throw std::runtime_error(loaded.error().message());
    return std::move(*loaded);
  }();
  return data;
}

PointCloud points_of(const Dataset& data) {
  auto points = initial_points(data, 1);
  if (!points) throw std::runtime_error(points.error().message());
  return std::move(*points);
}

TrainOptions short_run(int iterations) {
  TrainOptions options;
  options.iterations = iterations;
  options.densify_from = 20;
  options.densify_interval = 20;
  options.densify_until = iterations;
  options.sh_degree_interval = 30;
  options.opacity_reset_interval = 70;
  options.max_splats = 12000;
  return options;
}

TrainState train(const Dataset& data, const TrainOptions& options, TrainState state, int threads,
                 int steps) {
  const Threads pool(threads);
  StageTimes times;
  Trainer trainer(data, options, std::move(state), pool, times);
  for (int i = 0; i < steps && !trainer.done(); ++i) trainer.step();
  return trainer.state();
}

TrainState fresh(const Dataset& data, const TrainOptions& options) {
  const Threads threads(2);
  return initial_state(data, points_of(data), options, threads);
}

void expect_same(const PlanarFloats& a, const PlanarFloats& b, const char* what) {
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_EQ(a.size(), b.size()) << what;
  for (int r = 0; r < a.rows(); ++r)
    ASSERT_EQ(0, std::memcmp(a.row(r), b.row(r), a.size() * sizeof(float)))
        << what << ", row " << r;
}

void expect_same(const TrainState& a, const TrainState& b) {
  expect_same(a.parameters, b.parameters, "parameters");
  expect_same(a.adam.first, b.adam.first, "first moments");
  expect_same(a.adam.second, b.adam.second, "second moments");
  expect_same(a.statistics, b.statistics, "statistics");
  EXPECT_EQ(a.iteration, b.iteration);
  EXPECT_EQ(a.random, b.random);
  EXPECT_EQ(a.view_order, b.view_order);
  EXPECT_EQ(a.next_view, b.next_view);
}

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

TEST(Train, ResumingEqualsNeverHavingStopped) {
  const Dataset& data = small_capture();
  const TrainOptions options = short_run(110);
  const TrainState straight = train(data, options, fresh(data, options), 2, 110);
  const test::TempFolder folder;
  for (int stop : {1, 47, 80}) {  // 47: in the middle of a densification interval and of an epoch
    const TrainState half = train(data, options, fresh(data, options), 2, stop);
    ASSERT_TRUE(
        write_checkpoint(folder / "run.ckpt", {options, "3dgs", 1, data.train.size(), 7, half}));
    auto read = read_checkpoint(folder / "run.ckpt");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->options.max_splats, options.max_splats);
    expect_same(half, read->state);
    expect_same(straight, train(data, read->options, std::move(read->state), 1, 1000));
  }
}

TEST(Checkpoint, HashTellsPhotosApart) {
  std::vector<Photo> photos = small_capture().train;
  const std::uint64_t before = hash_photos(photos);
  EXPECT_EQ(before, hash_photos(photos));
  photos[3].rgb.pixels[100] ^= 1;
  EXPECT_NE(before, hash_photos(photos));
  photos = small_capture().train;
  photos[5].camera.translation.x += 1e-6;
  EXPECT_NE(before, hash_photos(photos));
}

TEST(Checkpoint, DamageIsAnErrorThatNamesTheFile) {
  const Dataset& data = small_capture();
  TrainOptions options = short_run(10);
  options.max_splats = 10;
  TrainState state = fresh(data, options);
  state.parameters = state.parameters.gather({0, 1, 2});
  state.adam = {state.adam.first.gather({0, 1, 2}), state.adam.second.gather({0, 1, 2})};
  state.statistics = state.statistics.gather({0, 1, 2});
  const test::TempFolder folder;
  const auto path = folder / "run.ckpt";
  ASSERT_TRUE(write_checkpoint(path, {options, "3dgs", 1, data.train.size(), 7, state}));
  const std::vector<std::byte> good = *read_file(path);
  for (std::size_t size = 0; size < good.size(); size += 61) {
    ASSERT_TRUE(write_file_atomic(path, std::span(good).first(size)));
    const auto read = read_checkpoint(path);
    ASSERT_FALSE(read) << size;
    EXPECT_NE(read.error().message().find("run.ckpt"), std::string::npos);
  }
  for (std::size_t at = 0; at < good.size(); at += 97) {
    std::vector<std::byte> bad = good;
    bad[at] ^= std::byte{0x41};
    ASSERT_TRUE(write_file_atomic(path, bad));
    ASSERT_FALSE(read_checkpoint(path)) << at;
  }
  ASSERT_FALSE(read_checkpoint(folder / "missing.ckpt"));
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
