// The command as people call it: results, exit statuses, and one clear line for bad input.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"
#include "fluxgs/io/scene.h"
#include "run_command.h"
#include "small_capture.h"
#include "support/sanitized.h"
#include "support/scenes.h"
#include "support/temp_folder.h"

namespace fluxgs {
namespace {

using nlohmann::json;
using test::capture_folder;
using test::expect_error;
using test::files_in;
using test::fluxgs;
using test::Outcome;
using test::quoted;
using test::text_of;
using test::train;
using testing::HasSubstr;
using testing::Not;

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path) << text;
}

TEST(Command, TrainsEvaluatesRendersConvertsAndInforms) {
  const test::TempFolder folder;
  const auto scene = folder / "scene.glb", report = folder / "report.json";
  const auto exact = folder / "exact.ply";
  const Outcome trained =
      fluxgs(train(scene, fmt::format("--iterations 60 --sh-target 3 --json {} --float-output {}",
                                      quoted(report), quoted(exact))));
  ASSERT_EQ(trained.status, 0) << trained.err;
  EXPECT_NE(trained.out.find("test views: PSNR "), std::string::npos) << trained.out;
  const json run = json::parse(text_of(report));
  for (const char* key : {"options", "iterations", "seconds", "cpu_seconds", "splats", "psnr",
                          "ssim", "curves", "stages", "backend", "versions"})
    EXPECT_TRUE(run.contains(key)) << key;
  EXPECT_EQ(run["iterations"], 60);
  for (const json& rate : run["curves"]["iterations_per_second"]) {
    EXPECT_GT(rate.get<double>(), 0);
    EXPECT_LT(rate.get<double>(), 1e5);
  }
  EXPECT_EQ(run["options"]["densify-until"], 30);  // half of the run, not the 0 that stands for it

  const Outcome scored =
      fluxgs(fmt::format("eval {} --data {} --json", quoted(scene), quoted(capture_folder())));
  ASSERT_EQ(scored.status, 0) << scored.err;
  const json score = json::parse(scored.out);
  EXPECT_EQ(score["views"].size(), 2u);
  EXPECT_NEAR(score["psnr"].get<double>(), run["psnr"].get<double>(), 1e-3);
  EXPECT_EQ(score["bytes"], std::filesystem::file_size(scene));

  const Outcome info = fluxgs(fmt::format("info {} --json", quoted(scene)));
  const json facts = json::parse(info.out);
  EXPECT_EQ(facts["splats"], run["splats"]);
  EXPECT_EQ(facts["sh_degree"], 3);
  EXPECT_EQ(facts["format"], "glb");
  EXPECT_EQ(facts["extensions"],
            json::array({"KHR_gaussian_splatting", "FLUXGS_gaussian_splatting_compact"}));
  EXPECT_EQ(facts["bytes"], run["bytes"]);
  const json before = json::parse(fluxgs(fmt::format("info {} --json", quoted(exact))).out);
  EXPECT_EQ(before["splats"], run["splats"]);
  EXPECT_GT(before["bytes"].get<double>(), 5 * facts["bytes"].get<double>());

  ASSERT_EQ(
      fluxgs(fmt::format("convert {} {}", quoted(scene), quoted(folder / "scene.ply"))).status, 0);
  EXPECT_EQ(json::parse(
                fluxgs(fmt::format("info {} --json", quoted(folder / "scene.ply"))).out)["splats"],
            run["splats"]);

  write_text(folder / "cameras.json",
             R"([{"name":"a","position":[0,0,-3],"target":[0,0,0],"up":[0,-1,0],"fovY":40},
                 {"name":"b","position":[1,0,-3],"target":[0,0,0],"up":[0,-1,0],"fovY":40}])");
  const Outcome drawn = fluxgs(
      fmt::format("render {} --camera {} --size 33x21 --renderer cpu --check --json -o {}",
                  quoted(scene), quoted(folder / "cameras.json"), quoted(folder / "view.png")));
  ASSERT_EQ(drawn.status, 0) << drawn.err;
  EXPECT_GT(json::parse(drawn.out)["reference_psnr"].get<double>(), 80.0);
  EXPECT_TRUE(std::filesystem::exists(folder / "view_a.png"));
  EXPECT_TRUE(std::filesystem::exists(folder / "view_b.png"));
}

TEST(Command, DoctorDrawsAPictureWithEachOpenGl) {
  const Outcome doctor = fluxgs("doctor --json");
  ASSERT_EQ(doctor.status, 0) << doctor.err;
  const json found = json::parse(doctor.out);
  int drawn = 0;
  for (const auto& [name, gl] : found["gl"].items()) {
    if (!gl["available"].get<bool>()) continue;
    EXPECT_TRUE(gl["picture"]["right"].get<bool>()) << name << ": " << gl["picture"].dump();
    EXPECT_TRUE(gl["picture"]["limits"].empty()) << name;
    ++drawn;
  }
  EXPECT_GE(drawn, 1);
}

TEST(Command, DoctorNamesTheWorkThatIsKept) {
  const test::TempFolder folder;
  const std::string cache = "XDG_CACHE_HOME=" + quoted(folder.path());
  EXPECT_THAT(fluxgs("doctor", cache).out, Not(HasSubstr("work kept")));
  std::filesystem::create_directories(folder / "fluxgs" / "photos-1" / "images");
  write_text(folder / "fluxgs" / "photos-1" / "images" / "a.jpg", std::string(3'000'000, 'x'));
  EXPECT_THAT(fluxgs("doctor", cache).out,
              HasSubstr("work kept   3 MB of photos and poses in " + folder.path().string()));
}

TEST(Command, MasksAreIgnoredCarvedOrLeftAside) {
  const test::TempFolder folder;
  const auto data = folder / "data", scene = folder / "scene.ply";
  capture::CaptureOptions small;
  small.width = 64, small.height = 48, small.train = 9, small.test = 2, small.samples = 1;
  small.occluder = true;
  ASSERT_TRUE(capture::write_capture(data, small));
  const auto run = [&](const std::string& more) {
    return fluxgs(fmt::format("train {} -o {} --force --max-splats 2000 --iterations 30 {}",
                              quoted(data), quoted(scene), more));
  };
  const Outcome trained = run("--json " + quoted(folder / "report.json"));
  ASSERT_EQ(trained.status, 0) << trained.err;
  EXPECT_THAT(trained.err,
              HasSubstr("9 of 11 photos have masked parts; training ignores these parts"));
  EXPECT_THAT(trained.err, HasSubstr("mask pruning at 6: "));
  EXPECT_EQ(json::parse(text_of(folder / "report.json"))["options"]["masks"], "auto");
  const auto psnr = [&](const std::string& masks) {
    const Outcome scored = fluxgs(fmt::format("eval {} --data {} --split train --masks {} --json",
                                              quoted(scene), quoted(data), masks));
    return json::parse(scored.out)["psnr"].get<double>();
  };
  const double ignored = psnr("ignore");
  EXPECT_GT(ignored, psnr("off")) << "the occluder is not what was trained";
  EXPECT_EQ(ignored, psnr("auto"));
  EXPECT_NE(ignored, psnr("carve"));

  // A checkpoint keeps the choice
  const Outcome carved = run("--masks carve --checkpoint-every 20");
  ASSERT_EQ(carved.status, 0) << carved.err;
  EXPECT_THAT(carved.err, HasSubstr("black or transparent parts; the scene stays empty there"));
  const std::string whole = text_of(scene);
  std::filesystem::remove(scene);
  const Outcome resumed = fluxgs(fmt::format("train {} -o {} --resume {}", quoted(data),
                                             quoted(scene), quoted(folder / "scene.ply.ckpt")));
  ASSERT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_EQ(text_of(scene), whole);
  EXPECT_THAT(run("--masks off").err, Not(HasSubstr("photos have")));
  EXPECT_EQ(run("--masks maybe").status, 2);
}

// Hours of training are not lost for a disk that was full at their end
TEST(Command, ATrainingWhoseSceneCannotBeWrittenIsSaved) {
  const test::TempFolder folder;
  const auto scene = folder / "scene.glb";
  // A folder takes its name while it is trained, after it was found to be free
  write_text(
      folder / "run.sh",
      fmt::format("'{}' {} 2>{} &\nwhile [ ! -e {} ] && kill -0 $!; do sleep 0.01; done\n"
                  "mkdir {}\nwait $!\n",
                  test::kFluxgs, train(scene, "--iterations 300 --checkpoint-every 10"),
                  quoted(folder / "said"), quoted(folder / "scene.glb.ckpt"), quoted(scene)));
  const int status = std::system(fmt::format("sh {}", quoted(folder / "run.sh")).c_str());
  const std::string said = text_of(folder / "said");
  ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 1) << said;
  EXPECT_NE(said.find("Checkpoint of iteration 300 saved. Resume with: fluxgs train "),
            std::string::npos)
      << said;
  std::filesystem::remove(scene);
  const Outcome stored =
      fluxgs(fmt::format("train {} -o {} --resume {} --json -", quoted(capture_folder()),
                         quoted(scene), quoted(folder / "scene.glb.ckpt")));
  ASSERT_EQ(stored.status, 0) << stored.err;
  // What it says is of the whole training, not of what was left of it
  const json report = json::parse(stored.out);
  EXPECT_EQ(report["resumed_at"], 300);
  EXPECT_EQ(report["curves"]["iteration"].back(), 300);
  EXPECT_GT(report["cpu_ms_per_iteration"], 0.01);
  EXPECT_GT(report["stages"]["backward"], 0);
  EXPECT_GT(report["stages_cpu"]["backward"], 0);
  EXPECT_TRUE(std::filesystem::is_regular_file(scene));
}

TEST(Command, UnknownNamesSuggestTheNearest) {
  const std::pair<const char*, const char*> cases[] = {
      {"trian x", "unknown sub-command trian; did you mean train?"},
      {"report codek x", "unknown sub-command codek; did you mean codec?"},
      {"train x -o y.glb --iteratoins 3",
       "unknown option --iteratoins; did you mean --iterations?"},
      {"train x -o y.glb --background 1", "expected 3 values with commas between them, 1 given"},
      {"train x -o y.glb --iterations 3 --iterations 4",
       "--iterations: given 2 times, expected once"},
      {"train x -o y.glb --late-prun-share=3", "did you mean --late-prune-share?"},
      {"train x -o y.glb 10 --iteration", "unknown option --iteration; did you mean --iterations?"},
      {"eval --dta x y.glb", "did you mean --data?"},
      {"info x.glb y.glb", "unknown argument y.glb (see --help)"},
      {"frobnicate", "unknown sub-command frobnicate (see --help)"},
      {"report", "expected a sub-command: codec, render, phone, sizes"}};
  for (const auto& [words, expected] : cases) {
    const Outcome outcome = fluxgs(words);
    EXPECT_EQ(outcome.status, 2) << words;
    EXPECT_THAT(outcome.err, HasSubstr(expected));
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  }
}

TEST(Command, AnInstructionSetThatIsNotThereIsAnError) {
  ASSERT_EQ(setenv("FLUXGS_ISA", "avx3", 1), 0);
  const Outcome outcome = fluxgs("doctor");
  unsetenv("FLUXGS_ISA");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.err, HasSubstr("FLUXGS_ISA: \"avx3\" is not of this processor; expected one "
                                     "of baseline"));
}

TEST(Command, WrongUsageIsStatusTwoAndHelpHasExamples) {
  EXPECT_EQ(fluxgs("").status, 2);
  EXPECT_EQ(fluxgs("fly").status, 2);
  EXPECT_EQ(fluxgs("train").status, 2);
  EXPECT_EQ(fluxgs("train x -o y.glb --iterations many").status, 2);
  EXPECT_EQ(fluxgs("train x -o y.glb --preset best").status, 2);
  EXPECT_EQ(fluxgs("train x -o y.glb --iterations 5.5").status, 2);
  EXPECT_EQ(fluxgs("train x -o y.glb --position-lr nan").status, 2);
  EXPECT_EQ(fluxgs("train x -o y.glb --background nan,0,0").status, 2);
  for (const char* seed : {"-1", "18446744073709551616", "0x2", "1.5", "''"})
    EXPECT_EQ(fluxgs(fmt::format("train x -o y.glb --seed {}", seed)).status, 2) << seed;
  EXPECT_EQ(fluxgs("train x -o y.glb --float-output ./y.glb").status, 2);
  EXPECT_EQ(fluxgs("convert x.ply y.glb --background 1,1,1").status, 2);
  EXPECT_EQ(fluxgs("convert x.ply y.glb --min-psnr 40 --downscale 2").status, 2);
  EXPECT_EQ(fluxgs("render x.glb -o y.png --size 0x9").status, 2);
  EXPECT_EQ(fluxgs("render x.glb -o y.png --size 12").status, 2);
  EXPECT_EQ(fluxgs("help trian").status, 2);
  EXPECT_THAT(fluxgs("help trian").err,
              HasSubstr("unknown sub-command trian; did you mean train?"));
  EXPECT_THAT(fluxgs("train x -o y.glb --downscale 2.5").err,
              HasSubstr("--downscale: '2.5': expected a whole number from 1 to 64"));
  EXPECT_THAT(fluxgs("train x -o y.glb --antialias maybe").err,
              HasSubstr("unknown argument maybe; --antialias takes on or off"));
  EXPECT_THAT(fluxgs("train x -o y.glb --checkpoint-every soon").err,
              HasSubstr("error: --checkpoint-every: 'soon'"));
  EXPECT_NE(fluxgs("train x -o y.glb --iterations 0")
                .err.find("expected a whole number from 1 to 1000000000"),
            std::string::npos);
  for (const char* command :
       {"train", "eval", "render", "view", "convert", "info", "web", "doctor"}) {
    const Outcome help = fluxgs(std::string(command) + " --help");
    EXPECT_EQ(help.status, 0);
    EXPECT_NE(help.out.find("Example: fluxgs " + std::string(command)), std::string::npos)
        << command;
  }
}

TEST(Command, BadDataSets) {
  const test::TempFolder folder;
  const auto out = folder / "out.glb";
  const auto attempt = [&](const std::string& data) {
    return fluxgs(fmt::format("train {} -o {} --iterations 5", quoted(folder / data), quoted(out)));
  };
  expect_error(attempt("missing"), {"missing"});
  std::filesystem::create_directory(folder / "empty");
  expect_error(attempt("empty"), {"empty", "expected"});

  json poses = json::parse(text_of(capture_folder() / "transforms_train.json"));
  std::filesystem::create_directory(folder / "none");
  for (json& frame : poses["frames"]) frame["file_path"] = "gone.png";
  write_text(folder / "none/transforms_train.json", poses.dump());
  expect_error(attempt("none"), {"none"});
  EXPECT_FALSE(std::filesystem::exists(out));
}

// One bad image of many, and one lost pose, cost the training nothing but themselves.
TEST(Command, BadImagesOfADataSetAreLeftOutAndNamed) {
  const test::TempFolder folder;
  std::filesystem::copy(capture_folder(), folder / "cut", std::filesystem::copy_options::recursive);
  const auto image = folder / "cut/train/r_003.png";
  std::filesystem::resize_file(image, std::filesystem::file_size(image) / 2);
  json poses = json::parse(text_of(folder / "cut/transforms_train.json"));
  poses["frames"][2]["transform_matrix"][0][3] = nullptr;
  write_text(folder / "cut/transforms_train.json", poses.dump());
  const auto run = fluxgs(fmt::format("train {} -o {} --preset 3dgs --iterations 5",
                                      quoted(folder / "cut"), quoted(folder / "out.ply")));
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, testing::HasSubstr("r_003.png: the image is truncated"));
  EXPECT_THAT(run.err, testing::HasSubstr("poses of 1 frames are not finite"));
}

TEST(Command, BadScenes) {
  const test::TempFolder folder;
  ASSERT_TRUE(write_scene(folder / "good.ply", test::random_cloud(10, 0, 1)));
  std::filesystem::resize_file(folder / "good.ply",
                               std::filesystem::file_size(folder / "good.ply") - 1);
  expect_error(fluxgs("info " + quoted(folder / "good.ply")), {"good.ply"});
  write_text(folder / "text.glb", "hello");
  expect_error(fluxgs("info " + quoted(folder / "text.glb")), {"text.glb"});
  expect_error(fluxgs("info " + quoted(folder / "no.ply")), {"no.ply"});
  expect_error(
      fluxgs(fmt::format("convert {} {}", quoted(folder / "no.ply"), quoted(folder / "x.obj"))),
      {"x.obj"});
}

TEST(Command, AnEmptySceneIsAWarning) {
  const test::TempFolder folder;
  ASSERT_TRUE(write_scene(folder / "none.ply", SplatCloud()));
  const Outcome o = fluxgs(fmt::format("render {} --renderer cpu --size 8x8 -o {}",
                                       quoted(folder / "none.ply"), quoted(folder / "v.png")));
  EXPECT_EQ(o.status, 0);
  EXPECT_NE(o.err.find("has no splats"), std::string::npos) << o.err;
}

TEST(Command, OutputThatCannotBeWrittenFailsBeforeTraining) {
  expect_error(fluxgs(train("/no/such/folder/out.glb", "--iterations 100000")),
               {"/no/such/folder"});
  expect_error(fluxgs(train("out.obj", "--iterations 100000")), {"out.obj"});
}

TEST(Command, InputIsNeverOverwritten) {
  const test::TempFolder folder;
  ASSERT_TRUE(write_scene(folder / "s.ply", test::random_cloud(10, 0, 1)));
  const std::vector<std::byte> scene = *read_file(folder / "s.ply");
  expect_error(fluxgs(fmt::format("render {0} -o {0}", quoted(folder / "s.ply"))),
               {"s.ply", ".png"});
  EXPECT_EQ(*read_file(folder / "s.ply"), scene);
  const auto poses = capture_folder() / "transforms_train.json";
  const std::string before = text_of(poses);
  expect_error(fluxgs(train(folder / "x.glb", "--iterations 1 --json " + quoted(poses))),
               {"transforms_train.json"});
  expect_error(fluxgs(train(folder / "x.glb", "--iterations 1 --force --json " + quoted(poses))),
               {"transforms_train.json", "outside of the data set"});
  EXPECT_EQ(text_of(poses), before);
  const test::TempFolder own;  // a data set with points in a .ply
  std::filesystem::copy(capture_folder(), own.path(), std::filesystem::copy_options::recursive);
  ASSERT_TRUE(write_scene(own / "points.ply", test::random_cloud(10, 0, 1)));
  json with_points = json::parse(before);
  with_points["ply_file_path"] = "points.ply";
  write_text(own / "transforms_train.json", with_points.dump());
  const std::string points = text_of(own / "points.ply");
  for (const char* option : {"-o", "-o x.glb --float-output"})
    expect_error(fluxgs(fmt::format("train {} --force {} {}", quoted(own.path()), option,
                                    quoted(own / "points.ply"))),
                 {"points.ply", "points of the data set"});
  EXPECT_EQ(text_of(own / "points.ply"), points);

  const auto view = capture_folder() / "test/r_000.png";
  const std::string pixels = text_of(view);
  expect_error(
      fluxgs(fmt::format("render {} --renderer cpu --data {} --view 0 -o {}",
                         quoted(folder / "s.ply"), quoted(capture_folder()), quoted(view))),
      {"r_000.png", "image"});
  EXPECT_EQ(text_of(view), pixels);
}

TEST(Command, LostOutputIsAnErrorAndLostMessagesAreNot) {
  const test::TempFolder folder;
  ASSERT_TRUE(write_scene(folder / "s.ply", test::random_cloud(10, 0, 1)));
  const auto status_of = [](const std::string& call) {
    return WEXITSTATUS(
        std::system(fmt::format("'{}' {} 2>/dev/null", test::kFluxgs, call).c_str()));
  };
  const std::string info = "info --json " + quoted(folder / "s.ply");
  EXPECT_EQ(status_of(info + " >/dev/null"), 0);
  for (const char* gone : {" >/dev/full", " >&-"}) {
    EXPECT_EQ(status_of(info + gone), 1) << gone;
    EXPECT_EQ(status_of(std::string("--help") + gone), 1) << gone;
  }
  const auto silent = [&](const std::string& out, const char* gone) {
    return WEXITSTATUS(std::system(
        fmt::format("'{}' {} {}", test::kFluxgs, train(folder / out, "--iterations 5"), gone)
            .c_str()));
  };
  EXPECT_EQ(silent("full.ply", "2>/dev/full"), 0);
  EXPECT_EQ(silent("closed.ply", "2>&-"), 0);
  EXPECT_EQ(*read_file(folder / "full.ply"), *read_file(folder / "closed.ply"));
}

TEST(Command, NamesFromStrangersStayOnOneLine) {
  const Outcome o = fluxgs("info " + quoted("no\nsuch\033[31mfile"));
  EXPECT_EQ(o.status, 1);
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  EXPECT_EQ(o.err.find('\033'), std::string::npos);
}

TEST(Command, ResumingOnOtherViewsIsRefused) {
  const test::TempFolder folder;
  ASSERT_EQ(fluxgs(train(folder / "a.ply", "--iterations 20 --checkpoint-every 10")).status, 0);
  std::filesystem::copy(capture_folder(), folder / "other",
                        std::filesystem::copy_options::recursive);
  std::filesystem::copy_file(folder / "other/train/r_001.png", folder / "other/train/r_002.png",
                             std::filesystem::copy_options::overwrite_existing);
  expect_error(fluxgs(fmt::format("train {} -o {} --resume {}", quoted(folder / "other"),
                                  quoted(folder / "b.ply"), quoted(folder / "a.ply.ckpt"))),
               {"other", "a.ply.ckpt", "have changed"});
  std::filesystem::remove(folder / "other/train/r_001.png");
  expect_error(fluxgs(fmt::format("train {} -o {} --resume {}", quoted(folder / "other"),
                                  quoted(folder / "b.ply"), quoted(folder / "a.ply.ckpt"))),
               {"other", "training images, expected the"});
}

TEST(Command, ResumingTakesItsOwnOptionsAgainAndNoOthers) {
  const test::TempFolder folder;
  const auto out = folder / "a.ply";
  const std::string options = "--iterations 20 --checkpoint-every 10 --seed 7 ";
  ASSERT_EQ(fluxgs(train(out, options)).status, 0);
  const std::string resume = fmt::format("--resume {}.ckpt ", out.string());
  EXPECT_EQ(fluxgs(train(out, options + resume)).status, 0);
  for (const char* other : {"--seed 9", "--downscale 3", "--preset 3dgs", "--background 1,1,1"})
    expect_error(fluxgs(train(out, resume + other)),
                 {std::string(other).substr(0, std::string_view(other).find(' ')),
                  "cannot be changed with --resume"});
}

TEST(Command, BadViews) {
  const test::TempFolder folder;
  ASSERT_TRUE(write_scene(folder / "s.ply", test::random_cloud(10, 0, 1)));
  const std::string call = fmt::format("render {} --renderer cpu -o {} ", quoted(folder / "s.ply"),
                                       quoted(folder / "v.png"));
  for (const char* view : {"1.5", "1e3", "0x1", "-1", "99", "''"})
    EXPECT_NE(
        fluxgs(call + fmt::format("--data {} --view {}", quoted(capture_folder()), view)).status, 0)
        << view;
  const std::string twice =
      R"({"name":"a","position":[0,0,-3],"target":[0,0,0],"up":[0,-1,0],"fovY":40})";
  write_text(folder / "c.json", "[" + twice + "," + twice + "]");
  expect_error(fluxgs(call + "--camera " + quoted(folder / "c.json")), {"c.json", "twice"});
  EXPECT_FALSE(std::filesystem::exists(folder / "v.png"));
}

TEST(Command, DiskFullLeavesNothingBehind) {
  const test::TempFolder folder;
  ASSERT_TRUE(write_scene(folder / "in.ply", test::random_cloud(3000, 3, 1)));
  std::filesystem::create_directory(folder / "out");
  const Outcome o =
      fluxgs(fmt::format("convert {} {}", quoted(folder / "in.ply"), quoted(folder / "out/x.glb")),
             "trap '' XFSZ; ulimit -f 64;");
  expect_error(o, {"x.glb"});
  EXPECT_EQ(files_in(folder / "out"), 0u);
}

// What the program has held, not what was estimated: in a run that would take far more.
TEST(Command, TrainingStaysWithinItsMemory) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "AddressSanitizer takes several times as much";
#endif
  const test::TempFolder folder;
  const auto peak_of = [&](const std::string& limit) {
    const Outcome run = fluxgs(fmt::format(
        "train {} -o {} --json {} --force --preset 3dgs --iterations 50 --densify-from 10 "
        "--densify-interval 6 --densify-until 48 --densify-gradient 1e-7 {}",
        quoted(capture_folder()), quoted(folder / "scene.glb"), quoted(folder / "run.json"),
        limit));
    EXPECT_EQ(run.status, 0) << run.err;
    constexpr double kMebibyte = 1 << 20;
    return json::parse(text_of(folder / "run.json"))["peak_memory_bytes"].get<double>() / kMebibyte;
  };
  constexpr int kLimit = 110;
  EXPECT_LE(peak_of(fmt::format("--max-memory {}", kLimit)), kLimit);
  EXPECT_GT(peak_of("--max-splats 30000"), kLimit);
}

TEST(Command, OutOfMemoryIsALine) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "AddressSanitizer needs the address space that this test takes away";
#endif
  const test::TempFolder folder;
  const std::size_t count = 20'000'000;
  write_text(folder / "huge.ply",
             fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n"
                         "property float x\nproperty float y\nproperty float z\n"
                         "property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\n"
                         "property float opacity\nproperty float scale_0\nproperty float scale_1\n"
                         "property float scale_2\nproperty float rot_0\nproperty float rot_1\n"
                         "property float rot_2\nproperty float rot_3\nend_header\n",
                         count));
  std::filesystem::resize_file(folder / "huge.ply",
                               std::filesystem::file_size(folder / "huge.ply") + 56 * count);
  expect_error(fluxgs("info " + quoted(folder / "huge.ply"), "ulimit -v 900000;"),
               {"huge.ply", "memory"});
}

TEST(Command, SaysWhichOptionsDoNothing) {
  const test::TempFolder folder;
  const auto said = [&](const std::string& options) {
    return fluxgs(train(folder / "scene.glb", "--force --iterations 20 " + options)).err;
  };
  EXPECT_THAT(said("--psi off --samples 64"), HasSubstr("--psi has no effect, expected"));
  EXPECT_THAT(said("--target-splats 1500"), HasSubstr("densification never takes place"));
  expect_error(fluxgs(train(folder / "x.glb", "--target-splats 3000")),
               {"--target-splats", "--max-splats 2000"});
  expect_error(fluxgs(train(folder / "x.glb", "--sh-target 1 --sh-degree 0 --phi on")),
               {"--phi", "--sh-degree"});
}

TEST(Command, SwitchesNeedNoValue) {
  const test::TempFolder folder;
  const auto plan = [&](const std::string& before, const std::string& after) {
    const Outcome said =
        fluxgs(fmt::format("train {} {} -o {} --plan {}", before, quoted(capture_folder()),
                           quoted(folder / "x.glb"), after));
    EXPECT_EQ(said.status, 0) << said.err;
    return said.out;
  };
  const auto on = HasSubstr("anti-aliasing");
  EXPECT_THAT(plan("--antialias", ""), on);
  EXPECT_THAT(plan("", "--antialias"), on);
  EXPECT_THAT(plan("", "--antialias on"), on);
  EXPECT_THAT(plan("", "--antialias --dilation 0.1"), on);
  EXPECT_THAT(plan("--antialias off", ""), Not(on));
  EXPECT_THAT(plan("", "--antialias=off"), Not(on));
}

// A .splat holds bytes, and no SH coefficients
TEST(Command, TheScoreIsThatOfTheFile) {
  const test::TempFolder folder;
  const auto scene = folder / "scene.splat";
  const Outcome trained = fluxgs(train(scene, "--preset 3dgs --iterations 200 --json -"));
  ASSERT_EQ(trained.status, 0) << trained.err;
  const json run = json::parse(trained.out);
  EXPECT_EQ(run["bytes"], std::filesystem::file_size(scene));
  EXPECT_NE(run["psnr"], run["psnr_before_compression"]);
  const Outcome scored =
      fluxgs(fmt::format("eval {} --data {} --json", quoted(scene), quoted(capture_folder())));
  EXPECT_NEAR(json::parse(scored.out)["psnr"].get<double>(), run["psnr"].get<double>(), 1e-3);
}

TEST(Command, InterruptedTrainingResumesToTheSameBytes) {
  const test::TempFolder folder;
  const std::string length =
      fmt::format("--iterations {} --threads 1", test::kSanitized ? 300 : 1000);
  const std::string report_to = " --json " + quoted(folder / "straight.json");
  ASSERT_EQ(fluxgs(train(folder / "straight.ply", length + report_to)).status, 0);
  // set -m: a background job of a shell without job control would ignore the interrupt
  write_text(
      folder / "interrupt.sh",
      fmt::format(
          "cd {}\nset -m\n'{}' {} --checkpoint-every 20 2>{} &\npid=$!\n"
          "while [ ! -e {} ] && kill -0 $pid; do sleep 0.02; done\nkill -INT $pid\nwait $pid\n",
          quoted(folder.path()), test::kFluxgs,
          train(folder / "stopped.ply", length + " --json stopped.json"), quoted(folder / "err"),
          quoted(folder / "stopped.ply.ckpt")));
  const int status = std::system(fmt::format("bash {}", quoted(folder / "interrupt.sh")).c_str());
  const std::string said = text_of(folder / "err");
  ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 1) << said;
  EXPECT_THAT(said, HasSubstr(fmt::format("--resume {}", (folder / "stopped.ply.ckpt").string())));
  EXPECT_THAT(said, HasSubstr(" --json stopped.json --threads 1 --checkpoint-every 20\n"));
  ASSERT_TRUE(std::filesystem::exists(folder / "stopped.ply.ckpt")) << said;
  EXPECT_FALSE(std::filesystem::exists(folder / "stopped.ply"));
  const Outcome resumed =
      fluxgs(fmt::format("train {} -o {} --resume {} --json -", quoted(capture_folder()),
                         quoted(folder / "stopped.ply"), quoted(folder / "stopped.ply.ckpt")));
  ASSERT_EQ(resumed.status, 0) << resumed.err;
  const json report = json::parse(resumed.out);
  const json marks = report["curves"]["iteration"];
  EXPECT_LT(marks.front(), report["resumed_at"]);
  EXPECT_GT(marks.back(), report["resumed_at"]);
  EXPECT_EQ(marks, json::parse(text_of(folder / "straight.json"))["curves"]["iteration"]);
  EXPECT_EQ(*read_file(folder / "straight.ply"), *read_file(folder / "stopped.ply"));
}

}  // namespace
}  // namespace fluxgs
