// fluxgs train, interrupted, resumed, and with files that are there already.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <regex>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"
#include "fluxgs/io/scene.h"
#include "run_command.h"
#include "small_capture.h"
#include "support/scenes.h"
#include "support/temp_folder.h"
#include "tools/fluxgs/options/checkpoint_interval.h"
#include "tools/fluxgs/terminal/interrupt.h"
#include "tools/fluxgs/terminal/run_lock.h"
#include "trainer/train/checkpoint.h"

namespace fluxgs {
namespace {

using nlohmann::json;
using test::capture_folder;
using test::expect_error;
using test::fluxgs;
using test::Outcome;
using test::quoted;
using test::text_of;
using test::train;
using testing::HasSubstr;
using testing::Not;

/// Runs fluxgs and sends it signals, `seconds` after one another, once a shell condition holds.
/// Standard error is the outcome's; a death by a signal is status 128 + its number.
Outcome interrupted(const std::string& arguments, const std::string& condition,
                    const std::string& signals) {
  const test::TempFolder folder;
  // set -m: a background job of a shell without job control would ignore the interrupt
  std::ofstream(folder / "run.sh") << fmt::format(
      "set -m\n'{}' {} 2>{} &\npid=$!\nwhile ! ( {} ) && kill -0 $pid; do sleep 0.02; done\n{}\n"
      "wait $pid\n",
      test::kFluxgs, arguments, quoted(folder / "err"),
      fmt::format(fmt::runtime(condition), fmt::arg("err", quoted(folder / "err"))), signals);
  const int status = std::system(fmt::format("bash {}", quoted(folder / "run.sh")).c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, "", text_of(folder / "err")};
}

TEST(Train, TwoInterruptsOfOnePressLeaveACheckpoint) {
  for (const char* signal : {"INT", "TERM"}) {
    const test::TempFolder folder;
    const auto out = folder / "scene.glb";
    const Outcome run =
        interrupted(train(out, "--iterations 1M"), "grep -q 'initial splats' {err}",
                    fmt::format("sleep 0.5; kill -{0} $pid; sleep 0.02; kill -{0} $pid", signal));
    EXPECT_EQ(run.status, 1) << run.err;
    EXPECT_THAT(run.err, HasSubstr("again to quit at once (no checkpoint has been saved yet)\n"));
    EXPECT_THAT(run.err, HasSubstr(fmt::format("--resume {}.ckpt", out.string())));
    EXPECT_TRUE(std::filesystem::exists(folder / "scene.glb.ckpt"));
    EXPECT_FALSE(std::filesystem::exists(folder / "scene.glb.lock"));
  }
}

TEST(Train, AClosedPipeLeavesACheckpoint) {
  const test::TempFolder folder;
  const auto out = folder / "scene.glb";
  const Outcome run = interrupted(train(out, "--iterations 1M"), "grep -q 'initial splats' {err}",
                                  "sleep 0.5; kill -PIPE $pid; sleep 0.7; kill -PIPE $pid");
  EXPECT_EQ(run.status, 1) << run.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "scene.glb.ckpt"));
}

TEST(Train, NoLockStaysBehindWhenLoadingIsInterrupted) {
  const test::TempFolder folder;
  const std::string lock = quoted(folder / "scene.glb.lock");
  const Outcome run = interrupted(train(folder / "scene.glb", "--iterations 1M"),
                                  fmt::format("test -e {}", lock), "kill -TERM $pid");
  EXPECT_NE(run.status, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "scene.glb.lock"));
}

// The disk of the result is full or was taken away.
TEST(Train, ATrainingThatCannotBeStoredIsSavedElsewhere) {
  const test::TempFolder folder;
  std::filesystem::create_directory(folder / "gone");
  const auto out = folder / "gone" / fmt::format("scene-{}.ply", ::getpid());
  const Outcome run = interrupted(train(out, "--iterations 150 --checkpoint-every 0"),
                                  "grep -q 'initial splats' {err}",
                                  fmt::format("rm -r {}", quoted(folder / "gone")));
  EXPECT_EQ(run.status, 1);
  const std::regex advice(
      "is saved as (.*\\.ckpt)\\. Resume with: fluxgs train .* --resume (.*\\.ckpt)");
  std::smatch found;
  ASSERT_TRUE(std::regex_search(run.err, found, advice)) << run.err;
  EXPECT_TRUE(is_checkpoint(found[1].str()));
  EXPECT_EQ(found[1], found[2]);
  std::filesystem::remove(found[1].str());
}

TEST(Train, PlanOfAResumedTrainingIsThatOfItsCheckpoint) {
  const test::TempFolder folder;
  const auto out = folder / "scene.glb";
  ASSERT_EQ(fluxgs(train(out, "--iterations 60")).status, 0);
  const Outcome plan =
      fluxgs(fmt::format("train --plan --resume {}.ckpt --iterations 90", out.string()));
  ASSERT_EQ(plan.status, 0) << plan.err;
  EXPECT_THAT(plan.out, HasSubstr("1-90 "));
  EXPECT_THAT(plan.out, testing::ContainsRegex("\n42 +once +SH reduction"));  // as it was
}

TEST(Train, BothResultsSayWhatTheirFormatsLose) {
  const test::TempFolder folder;
  const Outcome run =
      fluxgs(train(folder / "scene.glb",
                   fmt::format("--iterations 40 --float-output {}", quoted(folder / "s.splat"))));
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("s.splat: a .splat stores spherical harmonics up to degree 0"));
  EXPECT_THAT(run.err, HasSubstr("screen filter"));
}

TEST(Train, AMissedTargetIsSaid) {
  const test::TempFolder folder;
  const Outcome few =
      fluxgs(train(folder / "few.glb", "--iterations 30 --initial-splats 90 --target-splats 100"));
  EXPECT_THAT(few.err, HasSubstr("warning: --target-splats 100: there are only 90; "));
  const Outcome met = fluxgs(train(folder / "met.glb", "--iterations 30 --target-splats 20"));
  EXPECT_THAT(met.err, Not(HasSubstr("--target-splats")));
}

TEST(Train, TheSecondInterruptEndsTheProgramWithASecondLine) {
  const auto press_twice = [] {
    cli::Interrupts interrupts;
    interrupts.set_lines("first", "second");
    std::raise(SIGINT);
    std::raise(SIGINT);  // the same press
    if (!interrupts.any()) std::exit(3);
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    std::raise(SIGINT);
    std::exit(4);
  };
  EXPECT_EXIT(press_twice(), testing::KilledBySignal(SIGINT), "^first\nsecond\n$");
}

TEST(Train, NoInterruptIsHeardAfterTheEnd) {
  const auto press_late = [] {
    {
      cli::Interrupts interrupts;
      interrupts.set_lines("first", "second");
      interrupts.ignore();
      std::raise(SIGINT);
    }
    std::raise(SIGINT);
    std::_Exit(0);  // not through destructors, which remove what the other tests need
  };
  EXPECT_EXIT(press_late(), testing::ExitedWithCode(0), "^$");
}

TEST(Train, TheSecondInterruptWaitsForAFile) {
  const auto press_while_held = [] {
    cli::Interrupts interrupts;
    interrupts.set_lines("first", "early");
    std::raise(SIGTERM);
    {
      const cli::HoldInterrupts hold;
      std::this_thread::sleep_for(std::chrono::milliseconds(600));
      std::raise(SIGTERM);
      interrupts.set_lines("", "late");  // the file is written
    }
    std::exit(4);
  };
  EXPECT_EXIT(press_while_held(), testing::KilledBySignal(SIGTERM), "^first\nlate\n$");
}

/// Goes on from the checkpoint of an output.
Outcome resumed(const std::filesystem::path& out) {
  return fluxgs(fmt::format("train {} -o {} --resume {}.ckpt", quoted(capture_folder()),
                            quoted(out), out.string()));
}

TEST(Train, StoppedStoringResumesToTheSameBytes) {
  const test::TempFolder folder;
  const auto straight = folder / "straight.glb", stopped = folder / "stopped.glb";
  const std::string options = "--preset 3dgs --iterations 60";
  ASSERT_EQ(fluxgs(train(straight, options)).status, 0);
  // The checkpoint is saved just before the scene is stored
  const Outcome run = interrupted(
      train(stopped, options), fmt::format("test -e {}.ckpt", stopped.string()), "kill -TERM $pid");
  ASSERT_EQ(run.status, 1) << run.err;
  EXPECT_THAT(run.err, HasSubstr("interrupted at the storing of the scene: Checkpoint of iteration "
                                 "60 saved. Resume with: "));
  EXPECT_FALSE(std::filesystem::exists(stopped));
  const Outcome whole = resumed(stopped);
  ASSERT_EQ(whole.status, 0) << whole.err;
  EXPECT_EQ(*read_file(straight), *read_file(stopped));
}

TEST(Train, AFinishedTrainingGoesOn) {
  const test::TempFolder folder;
  const auto out = folder / "scene.glb";
  const Outcome first = fluxgs(train(out, "--iterations 60"));
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_THAT(first.err, HasSubstr("fluxgs view "));
  EXPECT_THAT(first.err, HasSubstr("--iterations 120"));
  // The advice on how to go on is a command that works as it stands
  const std::regex advice("Train it further: fluxgs (.*)\n");
  std::smatch line;
  ASSERT_TRUE(std::regex_search(first.err, line, advice)) << first.err;
  const Outcome typed = fluxgs(line[1].str());
  EXPECT_EQ(typed.status, 0) << typed.err;
  ASSERT_EQ(fluxgs(train(out, "--force --iterations 60")).status, 0);
  const std::string resume = fmt::format("train {} -o {} --resume {}.ckpt --json - ",
                                         quoted(capture_folder()), quoted(out), out.string());
  expect_error(fluxgs(resume + "--iterations 59"), {"--iterations", "fewer than the 60"});
  const Outcome more = fluxgs(resume + "--iterations 90");
  ASSERT_EQ(more.status, 0) << more.err;
  const json report = json::parse(more.out);
  EXPECT_EQ(report["resumed_at"], 60);
  EXPECT_EQ(report["iterations"], 90);
  EXPECT_EQ(report["options"]["iterations"], 90);
  EXPECT_EQ(report["options"]["densify-until"], 30);  // as it was
  EXPECT_TRUE(read_scene(out));
}

TEST(Train, FilesThatAreThereAreReplacedOnlyWhenForced) {
  const test::TempFolder folder;
  const auto out = folder / "scene.spz", report = folder / "report.json";  // stored at once
  const auto floats = folder / "scene.ply";
  const std::string options = fmt::format(
      "--iterations 5 --checkpoint-every 0 --json {} "
      "--float-output {}",
      quoted(report), quoted(floats));
  ASSERT_EQ(fluxgs(train(out, options)).status, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "scene.spz.ckpt"));
  for (const auto& path : {out, report, floats}) {
    for (const auto& other : {out, report, floats})
      if (other != path) std::filesystem::remove(other);
    const auto before = *read_file(path);
    expect_error(fluxgs(train(out, options)), {path.filename().string(), "exists", "--force"});
    EXPECT_EQ(*read_file(path), before);
    ASSERT_EQ(fluxgs(train(out, options + " --force")).status, 0);
  }
  expect_error(fluxgs(train(folder.path(), options)), {"is a folder", "name of a file"});
  expect_error(fluxgs(train(folder / "no/scene.spz", options + " --force")),
               {"scene.spz", "no does not exist"});
  // Nor is the checkpoint of another training
  std::filesystem::remove(out);
  std::ofstream(folder / "scene.spz.ckpt") << "days of work";
  expect_error(fluxgs(train(out, "--iterations 5")), {"scene.spz.ckpt", "exists", "--force"});
  EXPECT_EQ(text_of(folder / "scene.spz.ckpt"), "days of work");
  std::filesystem::remove(folder / "scene.spz.ckpt");
  ASSERT_EQ(fluxgs(train(out, "--iterations 5")).status, 0);
  std::filesystem::remove(out);
  expect_error(fluxgs(train(out, "--iterations 5")), {"scene.spz.ckpt", "--resume", "--force"});
}

TEST(Train, TwoRunsOfOneOutputAreRefused) {
  const test::TempFolder folder;
  const auto out = folder / "scene.ply";
  {
    const auto lock = cli::RunLock::take(out.string());
    ASSERT_TRUE(lock);
    expect_error(fluxgs(train(out, "--iterations 5")),
                 {"scene.ply", fmt::format("process {}", getpid())});
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "scene.ply.lock"));
  // A lock that a killed program left behind is none, whatever is in it
  for (const char* left : {"1\n", "99999999999999999999", ""}) {
    std::ofstream(folder / "scene.ply.lock") << left;
    EXPECT_EQ(fluxgs(train(out, "--iterations 5 --force")).status, 0) << left;
  }
  std::filesystem::create_directory(folder / "scene.ply.lock");
  expect_error(fluxgs(train(out, "--iterations 5 --force")), {"scene.ply.lock"});
}

// The small scene fits where neither the floats nor the checkpoint do
TEST(Train, WhatFitsOnAFullDiskIsWritten) {
  const test::TempFolder folder;
  const auto out = folder / "scene.glb", report = folder / "report.json";
  const Outcome run = fluxgs(train(out, fmt::format("--iterations 20 --json {} --float-output {}",
                                                    quoted(report), quoted(folder / "scene.ply"))),
                             "trap '' XFSZ; ulimit -f 40;");
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("fluxgs: error: " + (folder / "scene.ply").string()));
  EXPECT_THAT(run.err, HasSubstr("the training cannot be saved either"));
  EXPECT_TRUE(read_scene(out));
  EXPECT_EQ(json::parse(text_of(report))["iterations"], 20);
  EXPECT_FALSE(std::filesystem::exists(folder / "scene.ply"));
}

// The checkpoint of a finished training holds the scene as it was before it was stored, start view
// included
TEST(Train, CheckpointsAreScenes) {
  const test::TempFolder folder;
  const auto out = folder / "scene.glb";
  const std::string checkpoint = (folder / "scene.glb.ckpt").string();
  const auto floats = folder / "floats.ply";
  ASSERT_EQ(fluxgs(train(out, "--iterations 60 --float-output " + quoted(floats))).status, 0);
  const json of_file = json::parse(fluxgs("info --json " + quoted(out)).out);
  const Outcome info = fluxgs("info --json " + checkpoint);
  ASSERT_EQ(info.status, 0) << info.err;
  const json of_checkpoint = json::parse(info.out);
  EXPECT_EQ(of_checkpoint["format"], "checkpoint");
  EXPECT_EQ(of_checkpoint["splats"], of_file["splats"]);
  EXPECT_EQ(of_checkpoint["start"]["image_size"], json({64, 48}));
  EXPECT_EQ(of_file["start"]["image_size"], json({64, 48}));
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(of_checkpoint["start"]["position"][k].get<double>(),
                of_file["start"]["position"][k].get<double>(), 1e-5);
  const Outcome converted =
      fluxgs(fmt::format("convert {} {}", checkpoint, quoted(folder / "scene.ply")));
  ASSERT_EQ(converted.status, 0) << converted.err;
  EXPECT_THAT(converted.err, HasSubstr("a training, at iteration 60 of 60"));
  EXPECT_EQ(read_scene(folder / "scene.ply")->cloud.positions, read_scene(floats)->cloud.positions);

  std::filesystem::resize_file(checkpoint, std::filesystem::file_size(checkpoint) - 1);
  expect_error(fluxgs("info " + checkpoint), {"scene.glb.ckpt: checksum"});
}

TEST(Train, EvaluatesAtTheSizeOfTheTraining) {
  const test::TempFolder folder;
  const auto out = folder / "scene.glb", data = folder / "data";
  capture::CaptureOptions options;
  options.width = 160, options.height = 120, options.train = 8, options.test = 2,
  options.samples = 1;
  ASSERT_TRUE(capture::write_capture(data, options));
  const Outcome run =
      fluxgs(fmt::format("train {} -o {} --max-splats 2000 --iterations 60 "
                         "--downscale 2 --json -",
                         quoted(data), quoted(out)));
  ASSERT_EQ(run.status, 0) << run.err;
  const double trained = json::parse(run.out)["psnr"].get<double>();
  const auto score = [&](const std::string& more) {
    const Outcome scored =
        fluxgs(fmt::format("eval {} --data {} --json {}", quoted(out), quoted(data), more));
    return json::parse(scored.out)["psnr"].get<double>();
  };
  EXPECT_NEAR(score(""), trained, 1e-3);
  EXPECT_NEAR(score("--downscale 2"), trained, 1e-3);
  EXPECT_GT(std::abs(score("--downscale 1") - trained), 0.02);
}

// Lying on its side, a scene is drawn as it says that it stands
TEST(Train, OrbitsStandAsTheSceneDoes) {
  const test::TempFolder folder;
  const auto out = folder / "scene.glb";
  ASSERT_EQ(fluxgs(train(out, "--iterations 60 --float-output " + quoted(folder / "s.ply"))).status,
            0);
  const auto picture = [&](const std::filesystem::path& scene, const char* name) {
    const Outcome drawn =
        fluxgs(fmt::format("render {} --renderer cpu --size 40x30 --orbit 2 -o {}", quoted(scene),
                           quoted(folder / name)));
    EXPECT_EQ(drawn.status, 0) << drawn.err;
  };
  picture(out, "start.png");
  ASSERT_EQ(fluxgs(fmt::format("render {} --renderer cpu --size 40x30 -o {}", quoted(out),
                               quoted(folder / "first.png")))
                .status,
            0);
  // The first of the orbit is the view that it starts at, but for what is not level there
  EXPECT_NE(text_of(folder / "start_000.png"), text_of(folder / "start_001.png"));
  ASSERT_EQ(
      fluxgs(fmt::format("convert {} {}", quoted(folder / "s.ply"), quoted(folder / "s.splat")))
          .status,
      0);
  picture(folder / "s.splat", "guess.png");
  EXPECT_NE(text_of(folder / "start_000.png"), text_of(folder / "guess_000.png"));
}

TEST(Train, PicturesOfAPreviewAreOfOneView) {
  const test::TempFolder folder;
  const auto out = folder / "scene.glb";
  ASSERT_EQ(fluxgs(train(out, "--iterations 60 --preview-every 25")).status, 0);
  const auto pictures = folder / "scene.glb.preview";
  EXPECT_TRUE(std::filesystem::exists(pictures / "000025.png"));
  EXPECT_TRUE(std::filesystem::exists(pictures / "000050.png"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(pictures), {}), 2);
  EXPECT_NE(text_of(pictures / "000025.png"), text_of(pictures / "000050.png"));
  std::filesystem::remove(out);
  std::filesystem::remove(folder / "scene.glb.ckpt");
  expect_error(fluxgs(train(out, "--iterations 60 --preview-every 25")), {"scene.glb.preview"});
}

TEST(Train, AWindowThatCannotOpenDoesNotEndTheTraining) {
  const test::TempFolder folder;
  const Outcome run = fluxgs(train(folder / "scene.glb", "--iterations 1000 --preview"),
                             "env -u DISPLAY -u WAYLAND_DISPLAY");
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("fluxgs: error: "));  // the window's
}

TEST(Train, IntervalsOfCheckpoints) {
  const auto seconds = [](const char* text) {
    return cli::parse_checkpoint_interval(text)->seconds;
  };
  const auto iterations = [](const char* text) {
    return cli::parse_checkpoint_interval(text)->iterations;
  };
  EXPECT_EQ(seconds("90s"), 90);
  EXPECT_EQ(seconds("10m"), 600);
  EXPECT_EQ(seconds("1.5h"), 5400);
  EXPECT_EQ(seconds("5000"), 0);
  EXPECT_EQ(iterations("5000"), 5000);
  EXPECT_EQ(iterations("5k"), 5000);
  EXPECT_TRUE(cli::parse_checkpoint_interval("0")->never());
  EXPECT_TRUE(cli::parse_checkpoint_interval("0m")->never());
  for (const char* text :
       {"", "m", "-1m", "10 m", "nan", "nanm", "infh", "1.5", "-5", "10x", "5mm"})
    EXPECT_FALSE(cli::parse_checkpoint_interval(text)) << text;
  EXPECT_EQ(fluxgs("train x -o y.glb --checkpoint-every often").status, 2);
}

TEST(Train, WholeNumbersAsPeopleWriteThem) {
  const auto planned = [](const std::string& words) {
    return json::parse(fluxgs("train --plan --json - " + words).out)["options"];
  };
  EXPECT_EQ(planned("--iterations 30k")["iterations"], 30000);
  EXPECT_EQ(planned("--iterations 1e4")["iterations"], 10000);
  EXPECT_EQ(planned("--iterations 4.35k")["iterations"], 4350);
  EXPECT_EQ(planned("--max-splats 1.5M")["max-splats"], 1500000);
  EXPECT_EQ(planned("--seed 18446744073709551615")["seed"], 18446744073709551615U);
  for (const char* text : {"30kk", "k", "1.00001k", "3e", "1e30", "30 k"})
    EXPECT_EQ(fluxgs(fmt::format("train --plan --iterations '{}'", text)).status, 2) << text;
}

TEST(Train, HelpIsASubCommandToo) {
  EXPECT_EQ(fluxgs("help").out, fluxgs("--help").out);
  EXPECT_EQ(fluxgs("help train").out, fluxgs("train --help").out);
  EXPECT_EQ(fluxgs("help report codec").out, fluxgs("report codec --help").out);
  EXPECT_THAT(fluxgs("help train").out, HasSubstr("--checkpoint-every TIME=10m"));
}

}  // namespace
}  // namespace fluxgs
