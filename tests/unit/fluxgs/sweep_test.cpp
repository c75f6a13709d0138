// Sweeps of trainings: what is run, what is not run again, what is said of failures, and numbers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "run_command.h"
#include "support/temp_folder.h"
#include "tools/capture/capture.h"
#include "tools/fluxgs/command.h"
#include "tools/fluxgs/flip.h"
#include "tools/fluxgs/read_json.h"
#include "tools/fluxgs/report.h"
#include "tools/fluxgs/sweep.h"
#include "tools/fluxgs/sweep_plot.h"
#include "trainer/densify/splat_scores.h"

namespace fluxgs::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::expect_error;
using test::fluxgs;
using test::Outcome;
using test::quoted;
using test::text_of;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// A tiny capture in a folder of its own, kept for the whole program.
const fs::path& capture_folder() {
  static const test::TempFolder folder;
  static const bool made = [] {
    capture::CaptureOptions options;
    options.width = 48, options.height = 36, options.train = 8, options.test = 2,
    options.samples = 1;
    return capture::write_capture(folder / "spheres", options).has_value();
  }();
  if (!made) throw std::runtime_error("cannot make a capture");
  static const fs::path path = folder / "spheres";
  return path;
}

const std::string kTiny = " -- --iterations 60 --max-splats 300 --threads 1";

std::string report_train(const fs::path& out, const std::string& more,
                         const std::string& common = kTiny) {
  return fmt::format("report train {} -o {} --preset 3dgs {} {}{}", quoted(capture_folder()),
                     quoted(out), more.find("--frames") == std::string::npos ? "--frames 0" : "",
                     more, common);
}

SweepRow row(const std::string& name, std::vector<std::string> options) {
  return {"presets", name, name, "3dgs", std::move(options)};
}

SweepSettings tiny_settings(const fs::path& out, std::vector<SweepRow> rows) {
  return {.data = {capture_folder().string()},
          .out = out,
          .rows = std::move(rows),
          .seeds = {1, 2},
          .common = {"--iterations", "60", "--max-splats", "300", "--threads", "1"},
          .measures = {.frames = 0},
          .program = FLUXGS_BINARY};
}

fs::file_time_type time_of(const fs::path& file) { return fs::last_write_time(file); }

/// One scene, one row, these outcomes.
SweepTable table_of(std::vector<RunOutcome> outcomes, std::size_t scenes = 1) {
  SweepTable table{.command = "fluxgs report train"};
  for (std::size_t i = 0; i < scenes; ++i)
    table.scenes.push_back({fmt::format("scene{}", i), "folder", "0123"});
  table.rows = {row("flux", {})};
  for (std::size_t seed = 1; seed <= outcomes.size() / scenes; ++seed) table.seeds.push_back(seed);
  table.outcomes = std::move(outcomes);
  return table;
}

RunOutcome finished(double psnr) {
  return {.state = RunState::finished, .values = {{"psnr", psnr}, {"splats", 1000.0}}};
}

RunOutcome failed(const std::string& error) { return {.state = RunState::failed, .error = error}; }

TEST(SweepStatistics, MeanAndSampleDeviation) {
  const double values[] = {2, 4, 4, 4, 5, 5, 7, 9};  // squares of differences to 5: 32 in all
  const Statistic s = statistic_of(values);
  EXPECT_EQ(s.count, 8);
  EXPECT_DOUBLE_EQ(s.mean, 5);
  EXPECT_DOUBLE_EQ(s.deviation, std::sqrt(32.0 / 7));
  const double one[] = {3};
  EXPECT_DOUBLE_EQ(statistic_of(one).mean, 3);
  EXPECT_TRUE(std::isnan(statistic_of(one).deviation));
  EXPECT_TRUE(std::isnan(statistic_of({}).mean));
}

TEST(SweepStatistics, FailedRunsDoNotCount) {
  const SweepTable table = table_of({finished(30), failed("no splat is left"), finished(32)});
  const Statistic s = over_seeds(table, 0, 0, "psnr");
  EXPECT_EQ(s.count, 2);
  EXPECT_DOUBLE_EQ(s.mean, 31);
  EXPECT_DOUBLE_EQ(s.deviation, std::sqrt(2.0));
  EXPECT_EQ(over_seeds(table, 0, 0, "frame_ms").count, 0);
}

TEST(SweepStatistics, OverScenesTheDeviationIsThatOfSeeds) {
  // Seeds differ by 2 on average, scenes by 10; the third seed lacks a scene
  const SweepTable table = table_of(
      {finished(20), finished(22), finished(24), finished(30), finished(32), failed("x")}, 2);
  const Statistic s = over_scenes(table, 0, "psnr");
  EXPECT_EQ(s.count, 2);
  EXPECT_DOUBLE_EQ(s.mean, 26);
  EXPECT_DOUBLE_EQ(s.deviation, std::sqrt(2.0));
}

TEST(SweepTable, MarkdownShowsNumbersUnitsAndFailures) {
  const std::string text =
      sweep_markdown(table_of({finished(30), finished(32), failed("a | b\nfluxgs")}));
  EXPECT_THAT(text, HasSubstr("| | PSNR (dB) | splats | runs |\n|---|---:|---:|---:|\n"));
  EXPECT_THAT(text, HasSubstr("| flux | 31.00 ± 1.41 | 1000 ± 0 | 2 of 3, 1 failed |\n"));
  EXPECT_THAT(text, HasSubstr("- scene0, flux, seed 3 failed: a \\| b?fluxgs\n"));
}

TEST(SweepTable, SaysOfHowManyRunsANumberIs) {
  std::vector<RunOutcome> outcomes{finished(30), finished(32)};
  outcomes[1].values["stored_flip"] = 0.05;
  EXPECT_THAT(sweep_markdown(table_of(outcomes)),
              HasSubstr("| flux | 31.00 ± 1.41 | 0.0500 (1) | 1000 ± 0 | 2 |\n"));
  EXPECT_THAT(sweep_markdown(table_of(outcomes)),
              HasSubstr("- compact: FLIP: of 1 of 2 finished runs\n"));
}

TEST(SweepTable, SaysWhoMadeTheRunsAndWithHowManyThreads) {
  std::vector<RunOutcome> outcomes{finished(30), finished(32), failed("x")};
  outcomes[0].build = "this", outcomes[1].build = "that";
  outcomes[0].values["threads"] = 1, outcomes[1].values["threads"] = 2;
  SweepTable table = table_of(outcomes);
  table.build = "this";
  const std::string text = sweep_markdown(table);
  EXPECT_THAT(text, HasSubstr("- threads of the trainings: 1 or 2\n"));
  EXPECT_THAT(text, HasSubstr("- 1 of 2 finished runs were made by 1 builds of fluxgs"));
  table.outcomes[1].build = "this";
  EXPECT_THAT(sweep_markdown(table), Not(HasSubstr("builds of fluxgs")));
}

TEST(SweepTable, MarkdownShowsTheImagesOfItsGroups) {
  const std::string images[] = {"presets.png", "presets-curves.png", "parts.png"};
  const std::string text = sweep_markdown(table_of({finished(30), finished(32)}), images);
  EXPECT_THAT(text, HasSubstr("](presets.png) !["));
  EXPECT_THAT(text, HasSubstr("](presets-curves.png)\n"));
  EXPECT_THAT(text, Not(HasSubstr("parts.png"))) << "of a group that is not there";
}

TEST(SweepTable, ImagesHaveAPointARowAndBars) {
  SweepTable table = table_of({finished(30), finished(32)});
  table.rows[0].group = table.rows[0].series = "cameras";
  table.rows[0].x = 6;
  const Plot plot = sweep_plot(table, {"cameras", "Cameras", "views"});
  ASSERT_EQ(plot.series.size(), 1u);
  EXPECT_THAT(plot.series[0].points, ElementsAre(std::pair(6.0, 31.0)));
  EXPECT_THAT(plot.series[0].y_errors, ElementsAre(std::sqrt(2.0)));
}

TEST(SweepTable, CurvesAreMeansWhereAllRunsHaveMeasured) {
  SweepTable table = table_of({finished(30), finished(32), failed("x")});
  table.outcomes[0].curve = {{10, 20.0}, {20, 31.0}, {20, 30.0}};  // a switch at 20
  table.outcomes[1].curve = {{20, 33.0}, {20, 32.0}, {30, 34.0}};
  const Plot plot = sweep_curves(table, {"presets", "Presets"});
  ASSERT_EQ(plot.series.size(), 1u);
  EXPECT_THAT(plot.series[0].points, ElementsAre(std::pair(20.0, 32.0), std::pair(20.0, 31.0)));
  EXPECT_EQ(plot.y_from, 26.0);
}

TEST(SweepTable, CurvesLeaveOutSeedsThatLackAScene) {
  SweepTable table = table_of({finished(20), finished(22), finished(30), failed("x")}, 2);
  for (RunOutcome& o : table.outcomes)
    if (o.state == RunState::finished) o.curve = {{10, o.values.at("psnr")}};
  const Plot plot = sweep_curves(table, {"presets", "Presets"});
  ASSERT_EQ(plot.series.size(), 1u);
  EXPECT_THAT(plot.series[0].points, ElementsAre(std::pair(10.0, 25.0)));
}

TEST(SweepRows, OptionsOfTheDataAreTheSameInOneWordOrTwo) {
  EXPECT_EQ(training_meaning(row("a", {}), {"--downscale=2"}),
            training_meaning(row("a", {}), {"--downscale", "2"}));
}

TEST(SweepRows, NamesAreUniqueAndChosenByGroupOrName) {
  std::set<std::string> names;
  for (const SweepRow& r : all_sweep_rows()) EXPECT_TRUE(names.insert(r.name).second) << r.name;
  const auto rows = chosen_sweep_rows({"cameras", "densify-mcmc"}, "3dgs");
  ASSERT_TRUE(rows);
  EXPECT_EQ(rows->size(), 7u);
  EXPECT_EQ(rows->front().preset, "3dgs");
  EXPECT_EQ(rows->back().name, "densify-mcmc");
  EXPECT_FALSE(chosen_sweep_rows({"camera"}, ""));
  EXPECT_FALSE(chosen_sweep_rows({}, "best"));
}

TEST(SweepRows, ARowsOwnOptionsComeFirst) {
  EXPECT_THAT(merged_options({"--a", "1", "2", "--b=3", "--c"}, {"--b", "4", "--a", "5"}),
              ElementsAre("--c", "--b", "4", "--a", "5"));
  const auto meaning =
      meaning_of("3dgs", {"--score-views", "4", "--iterations=80", "--downscale", "2"});
  ASSERT_TRUE(meaning);
  EXPECT_EQ(meaning->get<ScoreOptions>().views, 4);
  EXPECT_EQ(meaning->iterations, 80);
  EXPECT_FALSE(meaning_of("3dgs", {"--score-views", "many"}));
}

TEST(Sweep, AFailingRowDoesNotLoseTheOthersAndIsTriedAgainWhenAsked) {
  const test::TempFolder folder;
  SweepSettings settings = tiny_settings(
      folder.path(), {row("good", {}), row("bad", {"--densify", "impossible"}), row("same", {})});
  const auto table = run_sweep(settings);
  ASSERT_TRUE(table) << table.error().message();
  EXPECT_EQ(table->count(RunState::finished), 4);  // "same" means the same as "good"
  EXPECT_EQ(table->count(RunState::failed), 2);
  EXPECT_THAT(table->at(0, 1, 0).error, HasSubstr("--densify"));
  EXPECT_THAT(table->at(0, 1, 0).error, HasSubstr("impossible"));
  EXPECT_EQ(over_seeds(*table, 0, 0, "psnr").count, 2);
  EXPECT_FALSE(fs::exists(folder / "spheres/same"));
  EXPECT_THAT(table->notes, ElementsAre("same means the same as good and has its runs"));
  for (const char* key : {"psnr", "ssim", "stored_psnr", "stored_ssim", "splats", "stored_bytes",
                          "ply_bytes", "seconds", "cpu_seconds"})
    EXPECT_TRUE(table->at(0, 0, 0).values.contains(key)) << key;
  EXPECT_LT(table->at(0, 0, 0).values.at("stored_bytes"),
            table->at(0, 0, 0).values.at("ply_bytes"));

  const auto report = folder / "spheres/good/seed-1/train.json";
  const auto log = folder / "spheres/bad/seed-1/log.txt";
  const auto trained = time_of(report);
  const auto tried = fs::file_size(log);
  const auto again = run_sweep(settings);
  ASSERT_TRUE(again);
  EXPECT_EQ(time_of(report), trained);
  EXPECT_EQ(fs::file_size(log), tried);
  EXPECT_EQ(sweep_json(*again).dump(), sweep_json(*table).dump());
  settings.retry = true;
  ASSERT_TRUE(run_sweep(settings));
  EXPECT_EQ(time_of(report), trained);
  EXPECT_GT(fs::file_size(log), tried);

  settings.retry = false;  // other words of the same meaning
  settings.rows = {row("good", {})};
  settings.seeds = {1};
  settings.common = {"--max-splats=300", "--threads", "2", "--iterations", "60"};
  ASSERT_TRUE(run_sweep(settings));
  EXPECT_EQ(time_of(report), trained);
  settings.rows = {row("good", {"--score-views", "4", "--opacity-lr", "0.03"})};
  const auto changed = run_sweep(settings);  // made again, but not in the place of the other
  ASSERT_TRUE(changed);
  EXPECT_NE(time_of(report), trained);
  EXPECT_EQ(time_of(folder / "spheres/good/seed-1.old-1/train.json"), trained);
  EXPECT_THAT(changed->at(0, 0, 0).remarks, ElementsAre(HasSubstr("put aside")));
}

void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

// After a power failure, say
TEST(Sweep, WhatCannotBeReadIsMadeAgainAndOddFilesCostOneRun) {
  const test::TempFolder folder;
  SweepSettings settings = tiny_settings(folder.path(), {row("good", {})});
  const auto first = run_sweep(settings);
  ASSERT_TRUE(first) << first.error().message();
  const fs::path run = folder / "spheres/good/seed-1";
  write(run / "score.json", "");
  const auto scored = run_sweep(settings);
  ASSERT_TRUE(scored);
  EXPECT_EQ(scored->at(0, 0, 0).values, first->at(0, 0, 0).values);
  for (const char* text : {"{\"psnr\": ", "[]"}) {
    write(run / "train.json", text);
    const auto trained = run_sweep(settings);
    ASSERT_TRUE(trained);
    EXPECT_EQ(trained->at(0, 0, 0).values.at("stored_psnr"),
              first->at(0, 0, 0).values.at("stored_psnr"));
  }
  fs::remove(run / "scene.glb");
  const auto again = run_sweep(settings);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->count(RunState::finished), 2);
  for (const char* scene : {"scene.glb", "scene.ply"}) {
    fs::resize_file(run / scene, 100);
    const auto whole = run_sweep(settings);
    ASSERT_TRUE(whole);
    EXPECT_EQ(whole->at(0, 0, 0).values.at("stored_bytes"),
              first->at(0, 0, 0).values.at("stored_bytes"));
    EXPECT_GT(fs::file_size(run / scene), 100u);
    EXPECT_THAT(whole->at(0, 0, 0).remarks, Contains(HasSubstr("damaged")));
  }
  const auto trained_at = time_of(run / "train.json");
  fs::remove(run / "scene.ply");  // large, and nothing reads it
  const auto without = run_sweep(settings);
  ASSERT_TRUE(without);
  EXPECT_EQ(without->at(0, 0, 0).values.at("ply_bytes"), first->at(0, 0, 0).values.at("ply_bytes"));
  EXPECT_EQ(time_of(run / "train.json"), trained_at);
  const std::string bytes = fmt::format("{}", fs::file_size(run / "scene.glb"));
  for (const std::string& odd :
       {"{\"psnr\": 1, \"bytes\": " + bytes + "}",
        "{\"psnr\": 1, \"bytes\": " + bytes + R"(, "curves": {"phases": [], "psnr": [null]}})"}) {
    write(run / "train.json", odd);
    const auto table = run_sweep(settings);
    ASSERT_TRUE(table) << odd;
    EXPECT_EQ(table->count(RunState::failed), 1) << odd;
    EXPECT_EQ(table->count(RunState::finished), 1) << odd;
    EXPECT_THAT(table->at(0, 0, 0).error, HasSubstr("seed-1")) << odd;
  }
  write(run / "run.json",
        "{\"data_hash\": \"\", \"version\": \"\", \"build\": \"\", \"steps\": []}");
  EXPECT_EQ(run_sweep(settings)->count(RunState::finished), 2);
}

/// A run that was stopped at step 40 of 60, by what its record tells.
fs::path stopped_run(const SweepSettings& settings, const fs::path& folder) {
  const fs::path run = folder / "spheres/full/seed-1";
  fs::create_directories(run);
  EXPECT_EQ(fluxgs(fmt::format("train {} -o {} --preset 3dgs --iterations 60 --max-splats 300 "
                               "--checkpoint-every 40",
                               quoted(capture_folder()), quoted(run / "scene.glb")))
                .status,
            0);
  const json record = {{"data_hash", *hash_of_data(capture_folder())},
                       {"version", FLUXGS_VERSION},
                       {"build", ""},
                       {"steps",
                        {{"train",
                          {{"meaning", training_meaning(settings.rows[0], settings.common)},
                           {"error", "ended by signal 9"}}}}}};
  EXPECT_TRUE(write_json((run / "run.json").string(), record));
  return run;
}

// Such as one that ran out of memory
TEST(Sweep, ARetriedRunGoesOnFromItsCheckpoint) {
  const test::TempFolder folder;
  SweepSettings settings = tiny_settings(folder.path(), {row("full", {})});
  settings.seeds = {1};
  const fs::path run = stopped_run(settings, folder.path());
  auto table = run_sweep(settings);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->at(0, 0, 0).error, "ended by signal 9");
  settings.retry = true;
  table = run_sweep(settings);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->at(0, 0, 0).state, RunState::finished) << table->at(0, 0, 0).error;
  EXPECT_THAT(text_of(run / "log.txt"), HasSubstr("resuming at iteration 40"));
  EXPECT_FALSE(fs::exists(run / "scene.glb.ckpt"));
}

TEST(Sweep, InterruptedItGoesOnWithTheSameCommand) {
  const test::TempFolder folder;
  const std::string length = " -- --iterations 400 --max-splats 300 --checkpoint-every 20";
  const std::string call =
      report_train(folder / "out", "--only densify-gradient,densify-mcmc --seeds 2", length);
  const fs::path runs = folder / "out/spheres";
  // set -m: a background job of a shell without job control would ignore the interrupt
  std::ofstream(folder / "interrupt.sh") << fmt::format(
      "set -m\n'{}' {} 2>{} >{} &\npid=$!\n"
      "while [ ! -e {} ] && kill -0 $pid; do sleep 0.02; done\nkill -INT $pid\nwait $pid\n",
      FLUXGS_BINARY, call, quoted(folder / "err"), quoted(folder / "said"),
      quoted(runs / "densify-mcmc/seed-1/scene.glb.ckpt"));
  const int status = std::system(fmt::format("bash {}", quoted(folder / "interrupt.sh")).c_str());
  const std::string said = text_of(folder / "err");
  ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 1) << said;
  EXPECT_THAT(said, HasSubstr("fluxgs: error: interrupted: 1 of 4 runs are finished; go on with: "
                              "fluxgs report train "));
  EXPECT_EQ(text_of(folder / "said"), "");
  EXPECT_THAT(text_of(folder / "out/report.md"), HasSubstr("1 of 2 |"));
  const auto trained = time_of(runs / "densify-gradient/seed-1/train.json");
  ASSERT_FALSE(fs::exists(runs / "densify-mcmc/seed-1/train.json"));
  const Outcome o = fluxgs(call);
  ASSERT_EQ(o.status, 0) << o.err;
  EXPECT_EQ(time_of(runs / "densify-gradient/seed-1/train.json"), trained);
  EXPECT_THAT(text_of(runs / "densify-mcmc/seed-1/log.txt"), HasSubstr("resuming at iteration "));
  EXPECT_THAT(o.out, HasSubstr("| densify gradient | "));
  const auto report = read_json(folder / "out/report.json");
  ASSERT_TRUE(report);
  ASSERT_EQ(report->at("rows").size(), 2u);
  for (const json& r : report->at("rows")) {
    EXPECT_EQ(r.at("statistics").at("psnr").at("count"), 2);
    EXPECT_EQ(r.at("runs").size(), 2u);
    EXPECT_EQ(r.at("runs")[1].at("state"), "finished");
  }
  // The report of the training has the time of both parts
  const auto resumed = read_json(runs / "densify-mcmc/seed-1/train.json");
  ASSERT_TRUE(resumed);
  EXPECT_EQ(report->at("rows")[1].at("runs")[0].at("values").at("cpu_seconds"),
            resumed->at("cpu_seconds"));
}

// The disk is full, say
TEST(Sweep, ACheckpointOutlivesFailuresThatAreNotItsOwn) {
  const test::TempFolder folder;
  SweepSettings settings = tiny_settings(folder.path(), {row("full", {})});
  settings.seeds = {1};
  settings.retry = true;
  const fs::path run = stopped_run(settings, folder.path());
  fs::create_directories(run / "scene.ply");  // where the scene is to be written
  auto table = run_sweep(settings);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->at(0, 0, 0).state, RunState::failed);
  EXPECT_TRUE(fs::exists(run / "scene.glb.ckpt"));
  fs::remove_all(run / "scene.ply");
  table = run_sweep(settings);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->at(0, 0, 0).state, RunState::finished) << table->at(0, 0, 0).error;
  EXPECT_THAT(text_of(run / "log.txt"), HasSubstr("resuming at iteration 40"));
}

// And one from which nothing can be trained is not tried for ever
TEST(Sweep, ACheckpointFromWhichTrainingFailsIsNotTriedAgain) {
  const test::TempFolder folder;
  SweepSettings settings = tiny_settings(folder.path(), {row("full", {})});
  settings.seeds = {1};
  const fs::path run = folder / "spheres/full/seed-1";
  ASSERT_TRUE(run_sweep(settings));
  fs::remove(run / "train.json");
  std::ofstream(run / "scene.glb.ckpt") << "no checkpoint";
  auto table = run_sweep(settings);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->at(0, 0, 0).state, RunState::failed);
  settings.retry = true;
  table = run_sweep(settings);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->at(0, 0, 0).state, RunState::finished) << table->at(0, 0, 0).error;
}

TEST(Sweep, RunsOfAnotherReportAreTakenOver) {
  const test::TempFolder folder;
  SweepSettings settings = tiny_settings(folder / "first", {row("good", {})});
  settings.seeds = {1};
  const auto first = run_sweep(settings);
  ASSERT_TRUE(first) << first.error().message();
  const std::string report = (folder / "report.json").string();
  ASSERT_TRUE(write_json(report, sweep_json(*first)));

  settings.out = folder / "second";
  ASSERT_TRUE(settings.known.add(report));
  settings.rows = {row("another-name", {}), row("other", {"--opacity-lr", "0.03"})};
  const auto second = run_sweep(settings);
  ASSERT_TRUE(second) << second.error().message();
  EXPECT_EQ(second->at(0, 0, 0).values, first->at(0, 0, 0).values);
  EXPECT_EQ(second->at(0, 0, 0).curve, first->at(0, 0, 0).curve);
  EXPECT_FALSE(second->at(0, 0, 0).curve.empty());
  EXPECT_FALSE(fs::exists(folder / "second/spheres/another-name"));
  EXPECT_TRUE(fs::exists(folder / "second/spheres/other/seed-1/train.json"));
  EXPECT_NE(second->at(0, 1, 0).values, first->at(0, 0, 0).values);

  // A folder is all reports in it
  fs::create_directory(folder / "reports");
  fs::copy_file(report, folder / "reports/one.json");
  std::ofstream(folder / "reports/one.md") << "not read";
  KnownRuns known;
  ASSERT_TRUE(known.add(folder / "reports"));

  // Neither another seed nor images of another size are the same run
  const json meaning = training_meaning(settings.rows[0], settings.common);
  const std::string& hash = first->scenes[0].hash;
  EXPECT_TRUE(settings.known.find(hash, meaning, 1));
  EXPECT_TRUE(known.find(hash, meaning, 1));
  EXPECT_FALSE(settings.known.find(hash, meaning, 2));
  EXPECT_FALSE(settings.known.find("0123", meaning, 1));
  settings.common.insert(settings.common.end(), {"--downscale", "2"});
  EXPECT_FALSE(settings.known.find(hash, training_meaning(settings.rows[0], settings.common), 1));
}

TEST(Sweep, BadUseIsOneLine) {
  const test::TempFolder folder;
  std::ofstream(folder / "odd.json") << R"({"versions": {"fluxgs": "0.0.0"}})";
  expect_error(fluxgs(report_train(folder / "out", "--known " + quoted(folder / "odd.json"))),
               {"odd.json", "versions", "0.0.0"});
  std::ofstream(folder / "odd.json") << R"({"scenes": []})";
  expect_error(fluxgs(report_train(folder / "out", "--known " + quoted(folder / "odd.json"))),
               {"odd.json", "report train"});
  expect_error(fluxgs(report_train(folder / "out", "--known " + quoted(folder / "none.json"))),
               {"none.json"});
  fs::create_directory(folder / "empty");
  expect_error(fluxgs(report_train(folder / "out", "--known " + quoted(folder / "empty"))),
               {"empty", ".json"});
  expect_error(fluxgs(report_train(folder / "out", "--only nothing")), {"--only", "nothing"});
  expect_error(
      fluxgs(fmt::format("report train {} -o {}", quoted(folder / "no"), quoted(folder / "out"))),
      {"no", "data set"});
  const auto hash = hash_of_data(capture_folder());
  expect_error(fluxgs(report_train(capture_folder() / "out", "--only densify")),
               {"--out", "inside"});
  EXPECT_FALSE(fs::exists(capture_folder() / "out"));
  EXPECT_EQ(hash_of_data(capture_folder()).value(), hash.value());
  EXPECT_EQ(fluxgs(report_train(folder / "out", "", " -- --seed 3")).status, 2);
  EXPECT_EQ(fluxgs(report_train(folder / "out", "", " -- --float-output x.ply")).status, 2);
  EXPECT_EQ(fluxgs(report_train(folder / "out", "", " -- -ox.glb")).status, 2);
  EXPECT_EQ(fluxgs("report train -o x").status, 2);
  EXPECT_EQ(fluxgs("report train x").status, 2);
  const Outcome listed = fluxgs("report train --list --only cameras");
  EXPECT_EQ(listed.status, 0);
  EXPECT_EQ(std::count(listed.out.begin(), listed.out.end(), '\n'), 6);
  EXPECT_THAT(fluxgs("report train --help").out, HasSubstr("Example: fluxgs report train"));
  const int lock = open((folder / "lock").c_str(), O_RDWR | O_CREAT, 0600);
  fs::create_directory(folder / "busy");
  fs::rename(folder / "lock", folder / "busy/.lock");
  ASSERT_EQ(flock(lock, LOCK_EX), 0);
  expect_error(fluxgs(report_train(folder / "busy", "--only densify")), {"busy", "at work"});
  close(lock);
  // A failure of all is one of the command
  expect_error(fluxgs(report_train(folder / "out", "--only densify-gradient --seeds 1",
                                   " -- --iterations nan")),
               {"none of the 1 runs succeeded", "--iterations"});
}

TEST(Sweep, WithoutGlOnlyTheFrameTimeIsMissing) {
  const test::TempFolder folder;
  const std::string call =
      report_train(folder / "out", "--only densify-gradient --seeds 1 --frames 1 --json");
  const Outcome o = fluxgs(call, "__EGL_VENDOR_LIBRARY_FILENAMES=/none");
  ASSERT_EQ(o.status, 0) << o.err;
  const json report = json::parse(o.out);
  EXPECT_EQ(report.at("rows")[0].at("statistics").at("frame_ms").at("count"), 0);
  EXPECT_EQ(report.at("rows")[0].at("statistics").at("psnr").at("count"), 1);
  EXPECT_THAT(report.at("notes").dump(), HasSubstr("no frame time: "));
}

TEST(Flip, OfTheSameImageIsNothing) {
  if (const auto there = check_flip(); !there) GTEST_SKIP() << there.error().message();
  View view;
  view.rgb = Image<std::uint8_t>(24, 16, 3);
  for (int x = 0; x < 24; ++x) view.rgb.at(x, 5)[0] = static_cast<std::uint8_t>(10 * x);
  const auto show = [&](float more) {
    return [&view, more](const Camera&) -> Expected<PlanarImage> {
      PlanarImage image(24, 16, 3);
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < 16; ++y)
          for (int x = 0; x < 24; ++x)
            image.row(c, y)[x] = static_cast<float>(view.rgb.at(x, y)[c]) / 255 + more;
      return image;
    };
  };
  const auto same = flip_errors({view}, show(0)), other = flip_errors({view}, show(0.3f));
  ASSERT_TRUE(same && other);
  EXPECT_DOUBLE_EQ(same->at(0), 0);
  EXPECT_GT(other->at(0), 0.1);
}

}  // namespace
}  // namespace fluxgs::cli
