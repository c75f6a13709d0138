// Videos: the sharp frames that are taken, and files that are no videos.
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "fake_program.h"
#include "tiny_colmap.h"
#include "trainer/core/process.h"
#include "trainer/data/dataset.h"
#include "trainer/data/photos/photo_list.h"
#include "trainer/data/photos/prepare_photos.h"
#include "trainer/data/photos/video_frames.h"

namespace fluxgs {
namespace {

using namespace test;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(SharpestFrames, OneOfEachPart) {
  const std::vector<double> values{1, 5, 2, 9, 3, 1, 1, 2};
  EXPECT_THAT(sharpest_frames(values, 2), ElementsAre(3, 4));
  EXPECT_THAT(sharpest_frames(values, 3), ElementsAre(1, 3, 7));
  EXPECT_THAT(sharpest_frames(values, 100), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
  EXPECT_TRUE(sharpest_frames({}, 5).empty());
}

/// Needs ffmpeg, which makes the videos, too.
class Video : public testing::Test {
 protected:
  void SetUp() override {
    const auto program = find_program("ffmpeg");
    if (!program) GTEST_SKIP() << "no ffmpeg";
    ffmpeg_ = *program;
  }
  fs::path here() const { return folder_.path(); }
  void make(const std::vector<std::string>& arguments) {
    std::vector<std::string> all{"-nostdin", "-y", "-v", "error"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    ASSERT_EQ(run({ffmpeg_, all, here() / "make.log"}), 0) << read_all(here() / "make.log");
  }
  /// A video of 40 numbered frames, of which every fifth is sharp.
  void make_video(const fs::path& file, const std::vector<std::string>& more = {}) {
    for (int i = 0; i < 40; ++i) {
      cv::Mat image(120, 160, CV_8UC3, cv::Scalar(255, 255, 255));
      for (int x = 8; x < 160; x += 8) cv::line(image, {x, 0}, {x, 120}, cv::Scalar(0, 0, 0), 2);
      if (i % 5 != 2) cv::GaussianBlur(image, image, {0, 0}, 3);
      cv::rectangle(image, {0, 0}, {39, 19}, cv::Scalar::all(6 * i), -1);
      fs::create_directories(here() / "frames");
      cv::imwrite((here() / "frames" / fmt::format("{:02}.png", i)).string(), image);
    }
    std::vector<std::string> all{
        "-framerate", "30",    "-i",   (here() / "frames/%02d.png").string(),
        "-c:v",       "mpeg4", "-q:v", "2"};
    all.insert(all.end(), more.begin(), more.end());
    all.push_back(file.string());
    make(all);
  }
  Expected<std::vector<std::string>> extract(const fs::path& video, int count) {
    warnings_.clear();
    if (auto ok = extract_video_frames(video, count, here() / "out", {}, warnings_); !ok)
      return std::unexpected(ok.error());
    std::vector<std::string> names;
    for (const Photo& photo : list_photos(here() / "out").photos) names.push_back(photo.name);
    return names;
  }
  /// The number of a frame by the grey of its corner.
  int number_of(const std::string& name) const {
    const cv::Mat image = cv::imread((here() / "out" / name).string());
    return static_cast<int>(std::lround(cv::mean(image(cv::Rect(5, 4, 28, 10)))[0] / 6));
  }

  const TempFolder folder_;
  fs::path ffmpeg_;
  std::vector<std::string> warnings_;
};

TEST_F(Video, TheSharpFrameOfEachPartIsTaken) {
  make_video(here() / "-a b:c%d.mp4");
  const auto names = extract(here() / "-a b:c%d.mp4", 8);
  ASSERT_TRUE(names) << names.error().message();
  ASSERT_EQ(names->size(), 8u);
  EXPECT_EQ(names->front(), "frame_00001.jpg");
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_NEAR(number_of((*names)[i]), 5 * static_cast<int>(i) + 2, 0) << i;
  EXPECT_TRUE(warnings_.empty());
  EXPECT_FALSE(fs::exists(here() / "out.partial"));
  EXPECT_EQ(extract(here() / "-a b:c%d.mp4", 500)->size(), 40u) << "no frame twice";
}

TEST_F(Video, RotationIsObeyed) {
  make_video(here() / "a.mp4");
  // As ffmpeg 6 writes it, or as ffmpeg 5 does
  const std::string from = (here() / "a.mp4").string(), to = (here() / "turned.mp4").string();
  const std::vector<std::string> common{"-nostdin", "-y", "-v", "error"};
  auto later = common, before = common;
  later.insert(later.end(), {"-display_rotation", "90", "-i", from, "-c", "copy", to});
  before.insert(before.end(), {"-i", from, "-c", "copy", "-metadata:s:v", "rotate=90", to});
  ASSERT_TRUE(run({ffmpeg_, later, "/dev/null"}) == 0 || run({ffmpeg_, before, "/dev/null"}) == 0);
  const auto names = extract(here() / "turned.mp4", 4);
  ASSERT_TRUE(names) << names.error().message();
  const auto outline = read_image_outline(here() / "out" / names->front());
  ASSERT_TRUE(outline);
  EXPECT_EQ(outline->size.width, 120);
  EXPECT_EQ(outline->size.height, 160);
}

TEST_F(Video, CutOffAndStrangeFiles) {
  make_video(here() / "a.mkv");
  const std::string whole = read_all(here() / "a.mkv");
  write_text(here() / "half.mkv", whole.substr(0, whole.size() / 2));
  const auto half = extract(here() / "half.mkv", 8);
  ASSERT_TRUE(half) << half.error().message();
  EXPECT_EQ(half->size(), 8u);

  make_video(here() / "a.mp4");
  const std::string mp4 = read_all(here() / "a.mp4");
  write_text(here() / "half.mp4", mp4.substr(0, mp4.size() / 2));
  expect_failure(extract(here() / "half.mp4", 8), "half.mp4", "ffmpeg says");
  write_text(here() / "text.mp4", "no video");
  expect_failure(extract(here() / "text.mp4", 8), "text.mp4", "ffmpeg says");
  write_text(here() / "empty.mp4", "");
  expect_failure(extract(here() / "empty.mp4", 8), "empty.mp4");
  make({"-f", "lavfi", "-i", "sine=duration=1", (here() / "sound.m4a").string()});
  fs::rename(here() / "sound.m4a", here() / "sound.mp4");
  expect_failure(extract(here() / "sound.mp4", 8), "sound.mp4", "ffmpeg says");
  // A playlist would lead to other files
  write_text(here() / "list.mp4", "#EXTM3U\n#EXT-X-TARGETDURATION:9\n#EXTINF:9,\nhttp://x/a.ts\n");
  expect_failure(extract(here() / "list.mp4", 8), "list.mp4");
  EXPECT_FALSE(fs::exists(here() / "out.partial"));
}

TEST_F(Video, AVideoIsADataSet) {
  TinyModel model;
  model.cameras[0].width = 160;
  model.cameras[0].height = 120;
  for (int i = 1; i <= 10; ++i) model.images.push_back({.name = fmt::format("frame_{:05}.jpg", i)});
  write_binary(here() / "models" / "0", model);
  write_fake_colmap(here());
  const ScopedVariable path("PATH", (here() / "bin").string() + ":/usr/bin:/bin");
  const ScopedVariable cache("XDG_CACHE_HOME", (here() / "cache").string());
  fs::create_directories(here() / "room");
  make_video(here() / "room" / "a.MOV");
  for (const char* given : {"room/a.MOV", "room"}) {
    const auto data = load_dataset(here() / given, {.test_every = 0, .video_frames = 10});
    ASSERT_TRUE(data) << data.error().message();
    EXPECT_EQ(data->kind, "video (COLMAP)");
    EXPECT_EQ(data->train.size(), 10u);
    EXPECT_EQ(data->train[9].camera.name, "frame_00010.jpg");
  }
  const std::size_t calls = lines_of_file(here() / "calls").size();
  EXPECT_EQ(load_dataset(here() / "room", {.test_every = 0})->train.size(), 10u) << "as before";
  EXPECT_EQ(lines_of_file(here() / "calls").size(), calls);
  const auto fewer = load_dataset(here() / "room", {.test_every = 0, .video_frames = 5});
  ASSERT_TRUE(fewer) << fewer.error().message();
  EXPECT_EQ(fewer->train.size(), 5u);
  EXPECT_GT(lines_of_file(here() / "calls").size(), calls);

  write_text(here() / "room" / "b.jpg", "x");
  write_image(here() / "room" / "c.png", pattern(32, 24));
  const auto mixed = load_dataset(here() / "room", {});
  ASSERT_FALSE(mixed) << "the photos are meant, and one of two cannot be read";
}

TEST(VideoBadInput, FfmpegMissingOrDying) {
  const TempFolder folder;
  const fs::path here = folder.path();
  write_text(here / "a.mp4", "x");
  std::vector<std::string> warnings;
  const auto extract = [&] {
    return extract_video_frames(here / "a.mp4", 5, here / "out", {}, warnings);
  };
  const ScopedVariable path("PATH", (here / "bin").string());
  expect_failure(extract(), "a.mp4", "apt install ffmpeg");
  write_program(here / "bin" / "ffmpeg", "kill -9 $$");
  expect_failure(extract(), "a.mp4", "killed by signal 9");
  write_program(here / "bin" / "ffmpeg", "echo '[mov @ 0x1] moov atom not found' >&2; exit 1");
  expect_failure(extract(), "a.mp4", "ffmpeg says: moov atom not found");
  // Dies when the frames are written
  write_program(here / "bin" / "ffmpeg",
                "case \"$*\" in *rawvideo*) /usr/bin/head -c 1000000 /dev/zero; exit 0;; esac\n"
                "echo 'No space left on device' >&2; exit 1");
  expect_failure(extract(), "a.mp4", "status 1", "No space left");
  EXPECT_FALSE(fs::exists(here / "out"));
  EXPECT_FALSE(fs::exists(here / "out.partial"));
}

}  // namespace
}  // namespace fluxgs
