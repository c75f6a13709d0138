// Runs that stop and go on: exactly as if they had never stopped.
#include <gtest/gtest.h>

#include <initializer_list>

#include "fluxgs/io/file.h"
#include "trainer/train/checkpoint.h"
#include "unit/trainer/train/short_run.h"

namespace fluxgs {
namespace {

using namespace test;

TEST(Train, ResumingEqualsNeverHavingStopped) {
  const Dataset& data = small_capture();
  const TrainOptions options = short_run(110);
  const TrainState straight = train(data, options, fresh(data, options), 2, 110);
  const TempFolder folder;
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

/// Interrupts a run at each of `stops` and goes on from a file.
void expect_resumable(const TrainOptions& options, std::initializer_list<int> stops) {
  const Dataset& data = small_capture();
  const int n = options.iterations;
  const TrainState straight = train(data, options, fresh(data, options), 2, n);
  const TempFolder folder;
  for (int stop : stops) {
    SCOPED_TRACE(stop);
    const TrainState half = train(data, options, fresh(data, options), 1, stop);
    ASSERT_TRUE(
        write_checkpoint(folder / "run.ckpt", {options, "flux", 1, data.train.size(), 7, half}));
    auto read = read_checkpoint(folder / "run.ckpt");
    ASSERT_TRUE(read) << read.error().message();
    expect_same(half, read->state);
    expect_same(straight, train(data, read->options, std::move(read->state), 1, n));
  }
}

TEST(Train, ResumingWithOwnDegreesAndRounding) {
  TrainOptions options = short_run(90);
  options.densify_until = 40;
  options.sh_degree_interval = 10;
  options.sh_target = ShTarget::adaptive;
  options.sh_loss = 0.5;
  options.switch_iteration = 50;
  options.rounding = Switch::on;
  options.round_from = 60;
  options.round_interval = 7;
  expect_resumable(options, {45, 75});
}

TEST(Train, ResumingWithNetworks) {
  TrainOptions options = short_run(60);
  options.sh_degree_interval = 8;
  options.switch_iteration = 35;
  options.sh_target = ShTarget::degree_1;
  options.sh_reduce = ShReduction::energy;
  options.phi = Switch::on;
  options.psi_fit_steps = 20;
  expect_resumable(options, {30, 45});
  options.dropout = 3;
  expect_resumable(options, {45});
}

TEST(Train, ResumingWithEverything) { expect_resumable(everything(), {50, 72, 90}); }

TEST(Train, ResumingMcmc) { expect_resumable(mcmc_run(60), {33}); }

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
  const TempFolder folder;
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

}  // namespace
}  // namespace fluxgs
