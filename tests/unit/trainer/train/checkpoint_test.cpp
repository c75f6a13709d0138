// Runs that stop and go on: exactly as if they had never stopped.
#include <gtest/gtest.h>

#include <cstring>

#include <nlohmann/json.hpp>
#include <vector>

#include "fluxgs/hash.h"
#include "fluxgs/io/file.h"
#include "support/sanitized.h"
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
void expect_resumable(const TrainOptions& options, const std::vector<int>& stops) {
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

TEST(Train, ResumingWithOwnDegrees) {
  TrainOptions options = short_run(90);
  options.get<DensificationOptions>().until = 40;
  options.get<ShCurriculumOptions>().interval = 10;
  options.get<ShReductionOptions>().target = ShTarget::adaptive;
  options.get<ShReductionOptions>().max_psnr_drop = 0.5;
  options.get<ShReductionOptions>().iteration = 50;
  expect_resumable(options, {45, 75});
}

TEST(Train, ResumingWithNetworks) {
  TrainOptions options = short_run(60);
  options.get<ShCurriculumOptions>().interval = 8;
  options.get<ShReductionOptions>().iteration = 35;
  options.get<ShReductionOptions>().target = ShTarget::degree_1;
  options.get<ShReductionOptions>().reduce = ShReduction::energy;
  options.get<NetworkColorOptions>().phi = true;
  options.get<NetworkColorOptions>().psi_fit_iterations = 20;
  expect_resumable(options, {30, 45});
  options.get<DropoutOptions>().dropout = 3;
  expect_resumable(options, {45});
}

TEST(Train, ResumingWithEverything) {
  expect_resumable(everything(), kSanitized ? std::vector{72} : std::vector{50, 72, 90});
}

TEST(Train, ResumingMcmc) { expect_resumable(mcmc_run(60), {33}); }

TEST(Checkpoint, HashTellsViewsApart) {
  std::vector<View> views = small_capture().train;
  const std::uint64_t before = hash_views(views);
  EXPECT_EQ(before, hash_views(views));
  views[3].rgb.pixels[100] ^= 1;
  EXPECT_NE(before, hash_views(views));
  views = small_capture().train;
  views[5].camera.translation.x += 1e-6;
  EXPECT_NE(before, hash_views(views));
}

/// A checkpoint with three splats.
std::vector<std::byte> small_checkpoint(const std::filesystem::path& path,
                                        const TrainOptions& options) {
  const Dataset& data = small_capture();
  TrainState state = fresh(data, options);
  state.parameters = state.parameters.gather({0, 1, 2});
  state.adam = {state.adam.first.gather({0, 1, 2}), state.adam.second.gather({0, 1, 2})};
  state.statistics = state.statistics.gather({0, 1, 2});
  EXPECT_TRUE(write_checkpoint(path, {options, "3dgs", 1, data.train.size(), 7, state}));
  return *read_file(path);
}

TEST(Checkpoint, DamageIsAnErrorThatNamesTheFile) {
  TrainOptions options = short_run(10);
  options.max_splats = 10;
  const TempFolder folder;
  const auto path = folder / "run.ckpt";
  const std::vector<std::byte> good = small_checkpoint(path, options);
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

TEST(Checkpoint, AnotherVersionIsOneClearLine) {
  const TempFolder folder;
  const auto path = folder / "run.ckpt";
  std::vector<std::byte> file = small_checkpoint(path, short_run(10));
  file[8] = std::byte{2};
  ASSERT_TRUE(write_file_atomic(path, file));
  const auto read = read_checkpoint(path);
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message().find("another version of fluxgs"), std::string::npos);
  EXPECT_EQ(read.error().message().find('\n'), std::string::npos);
}

constexpr std::size_t kHeaderSizeAt = 12, kHeaderAt = 16;

nlohmann::json header_of(const std::vector<std::byte>& file) {
  std::uint32_t size;
  std::memcpy(&size, &file[kHeaderSizeAt], sizeof size);
  const char* text = reinterpret_cast<const char*>(&file[kHeaderAt]);
  return nlohmann::json::parse(text, text + size);
}

/// The file with another header, and a checksum that is right.
std::vector<std::byte> with_header(const std::vector<std::byte>& file, const std::string& header) {
  std::uint32_t old_size;
  std::memcpy(&old_size, &file[kHeaderSizeAt], sizeof old_size);
  const auto size = static_cast<std::uint32_t>(header.size());
  std::vector<std::byte> result(file.begin(), file.begin() + kHeaderAt);
  std::memcpy(&result[kHeaderSizeAt], &size, sizeof size);
  for (char c : header) result.push_back(static_cast<std::byte>(c));
  result.insert(result.end(), file.begin() + kHeaderAt + old_size, file.end() - 8);
  const std::uint64_t hash = fnv1a(result);
  for (int i = 0; i < 8; ++i) result.push_back(static_cast<std::byte>(hash >> (8 * i)));
  return result;
}

std::string error_for(const std::filesystem::path& path, const std::vector<std::byte>& file) {
  EXPECT_TRUE(write_file_atomic(path, file));
  const auto read = read_checkpoint(path);
  return read ? "" : read.error().message();
}

// Bytes from strangers, whose checksum is right.
TEST(Checkpoint, WhatNoTrainingHasIsAnErrorThatNamesTheField) {
  const TempFolder folder;
  const auto path = folder / "run.ckpt";
  const std::vector<std::byte> good = small_checkpoint(path, short_run(10));
  const nlohmann::json header = header_of(good);
  EXPECT_EQ(error_for(path, with_header(good, header.dump())), "");
  const struct {
    const char *change, *field;
  } cases[] = {
      {R"({"sh_degree": 7})", "sh_degree"},
      {R"({"sh_degree": 0})", "sh_degree"},
      {R"({"sh_degree": -1})", "sh_degree"},
      {R"({"own_degrees": true})", "splats"},
      {R"({"attached": [["latents", 12, false]]})", "splats"},
      {R"({"attached": [["latents", 0, false]]})", "splats"},
      {R"({"attached": [["latents", 1000000000, false]]})", "splats"},
      {R"({"attached": [["latents"]]})", "header"},
      {R"({"attached": 3})", "header"},
      {R"({"phase_values": [["network colours", 1152921504606846976]]})", "splats"},
      {R"({"phase_values": [["network colours", -1]]})", "splats"},
      {R"({"compact_output": 3})", "header"},
      {R"({"iteration": -1})", "iteration"},
      {R"({"iteration": 11})", "iteration"},
      {R"({"iteration": 1099511627776})", "iteration"},
      {R"({"iteration": 1e300})", "header"},
      {R"({"splats": 4611686018427387904})", "splats"},
      {R"({"splats": -1})", "splats"},
      {R"({"splats": 2})", "splats"},
      {R"({"downscale": -1})", "downscale"},
      {R"({"max_pairs": -1})", "max_pairs"},
      {R"({"splat_worth": "high"})", "header"},
      {R"({"random": ""})", "random"},
      {R"({"next_view": 1000})", "next_view"},
      {R"({"next_view": -1})", "next_view"},
      {R"({"view_order": []})", "view_order"},
      {R"({"train_views": -1})", "view_order"},
      {R"({"options": {"iterations": -5}})", "--iterations"},
      {R"({"options": {"iterations": 4294967297}})", "--iterations"},
      {R"({"options": 3})", "header"},
  };
  for (const auto& [change, field] : cases) {
    nlohmann::json changed = header;
    changed.merge_patch(nlohmann::json::parse(change));
    const std::string error = error_for(path, with_header(good, changed.dump()));
    EXPECT_NE(error.find(field), std::string::npos) << change << ": " << error;
  }
  // Nothing behind the header, and a size that is none
  nlohmann::json empty = header;
  empty["sh_degree"] = 7;
  std::vector<std::byte> file = with_header(good, empty.dump());
  file.resize(kHeaderAt + empty.dump().size() + 8);
  EXPECT_NE(error_for(path, with_header(file, empty.dump())), "");
}

// Whatever one value of the header becomes: an error, or a training that goes on.
TEST(Checkpoint, AnyValueOfTheHeaderIsRefusedOrTrainsOn) {
  const Dataset& data = small_capture();
  const TempFolder folder;
  const auto path = folder / "run.ckpt";
  const TrainOptions options = short_run(10);
  const std::vector<std::byte> good = small_checkpoint(path, options);
  const nlohmann::json header = header_of(good);
  const nlohmann::json values = {-1,
                                 0,
                                 1,
                                 7,
                                 1LL << 40,
                                 1e300,
                                 "",
                                 nullptr,
                                 true,
                                 nlohmann::json::array(),
                                 nlohmann::json::object()};
  int refused = 0, trained = 0;
  for (const auto& [key, old] : header.items())
    for (const auto& value : values) {
      nlohmann::json changed = header;
      changed[key] = value;
      ASSERT_TRUE(write_file_atomic(path, with_header(good, changed.dump())));
      auto read = read_checkpoint(path);
      if (!read) {
        ++refused;
        continue;
      }
      SCOPED_TRACE(key + " = " + value.dump());
      ASSERT_EQ(read->train_views, data.train.size());
      train(data, read->options, std::move(read->state), 1, read->state.iteration + 2);
      ++trained;
    }
  EXPECT_GT(refused, 100);
  EXPECT_GT(trained, 10);
}

}  // namespace
}  // namespace fluxgs
