// Data sets on the command line: which images are for testing, how far they are reduced, photos
// without poses.
#include <nlohmann/json.hpp>

#include <gmock/gmock.h>

#include "run_command.h"
#include "tools/capture/capture.h"

namespace fluxgs {
namespace {

using namespace test;
using testing::HasSubstr;
using testing::Not;

class DataOptions : public testing::Test {
 protected:
  void SetUp() override {
    capture::CaptureOptions options;
    options.width = 64, options.height = 48, options.train = 8, options.test = 2,
    options.samples = 1;
    ASSERT_TRUE(capture::write_capture(data(), options));
  }
  std::filesystem::path data() const { return folder_ / "capture"; }
  Outcome train(const std::string& more) const {
    return fluxgs(fmt::format("train {} -o {} --force --iterations 5 --max-splats 500 {}",
                              quoted(data()), quoted(folder_ / "a.ply"), more));
  }
  const TempFolder folder_;
};

TEST_F(DataOptions, AllImagesForTraining) {
  const Outcome split = train("");
  ASSERT_EQ(split.status, 0) << split.err;
  EXPECT_THAT(split.err, HasSubstr("8 training and 2 test images"));
  EXPECT_THAT(split.out, HasSubstr("test views: PSNR"));
  const Outcome all = train("--holdout none --json " + quoted(folder_ / "a.json"));
  ASSERT_EQ(all.status, 0) << all.err;
  EXPECT_THAT(all.err, HasSubstr("10 training and 0 test images"));
  EXPECT_THAT(all.out, HasSubstr("training views, as there are none for testing: PSNR"));
  const auto report = nlohmann::json::parse(text_of(folder_ / "a.json"));
  EXPECT_EQ(report["scored_views"], "train");
  EXPECT_GT(report["psnr"].get<double>(), 5);

  const std::string eval =
      fmt::format("eval {} --data {} ", quoted(folder_ / "a.ply"), quoted(data()));
  expect_error(fluxgs(eval + "--holdout none"), {"has no test images", "--split train"});
  const Outcome scored = fluxgs(eval + "--holdout none --split train --json");
  ASSERT_EQ(scored.status, 0) << scored.err;
  EXPECT_NEAR(nlohmann::json::parse(scored.out)["psnr"].get<double>(), report["psnr"].get<double>(),
              1e-3);
}

TEST_F(DataOptions, HoldoutByNumberAndByList) {
  EXPECT_THAT(train("--holdout every-5").err, HasSubstr("8 training and 2 test images"));
  EXPECT_THAT(train("--holdout every-2").err, HasSubstr("5 training and 5 test images"));
  std::ofstream(folder_ / "names") << "r_003\nr_004\nr_005\n";
  EXPECT_THAT(train("--holdout " + quoted(folder_ / "names")).err, HasSubstr("training and "));
  for (const char* bad : {"every-1", "every-", "every-x", "all", "8", "every-8x", "every--3"})
    expect_error(train(std::string("--holdout ") + bad), {"--holdout", bad, "every-N"});
}

TEST_F(DataOptions, TooSmallImagesAreRefusedBeforeAnyWork) {
  expect_error(train("--downscale 64"), {"downscale", "1x0 of 64x48", "at most 1"});
  EXPECT_EQ(train("--downscale 0").status, 2);
  EXPECT_EQ(train("--downscale 65").status, 2);
}

TEST_F(DataOptions, PhotosWithoutTheProgramsTheyNeed) {
  std::filesystem::create_directories(folder_ / "photos");
  for (const char* name : {"r_000.png", "r_001.png"})
    std::filesystem::copy(data() / "train" / name, folder_ / "photos" / name);
  std::ofstream(folder_ / "video.mp4") << "no video";
  const std::string before = fmt::format("PATH=/nowhere XDG_CACHE_HOME={}", quoted(folder_ / "c"));
  const auto try_it = [&](const char* input) {
    return fluxgs(fmt::format("train {} -o {}", quoted(folder_ / input), quoted(folder_ / "a.ply")),
                  before);
  };
  expect_error(try_it("photos"), {"photos", "apt install colmap"});
  expect_error(try_it("video.mp4"), {"video.mp4", "apt install"});
  expect_error(try_it("nothing.mp4"), {"nothing.mp4", "no such"});
  expect_error(try_it("photos/r_000.png"), {"r_000.png", "neither a folder"});
}

}  // namespace
}  // namespace fluxgs
