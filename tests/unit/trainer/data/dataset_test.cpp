// Loading folders: what they may be, pixels, and COLMAP as a program.
#include <sys/stat.h>

#include "tiny_colmap.h"
#include "trainer/data/dataset.h"
#include "trainer/data/run_colmap.h"

namespace fluxgs {
namespace {

using namespace test;

/// PATH for the time of a test.
class ScopedPath {
 public:
  explicit ScopedPath(const std::string& value) {
    if (const char* old = std::getenv("PATH")) old_ = old;
    setenv("PATH", value.c_str(), 1);
  }
  ScopedPath(const ScopedPath&) = delete;
  ScopedPath& operator=(const ScopedPath&) = delete;
  ~ScopedPath() { setenv("PATH", old_.c_str(), 1); }

 private:
  std::string old_;
};

void write_one_view(const fs::path& folder, const Image<std::uint8_t>& image,
                    const std::string& intrinsics = "\"fl_x\": 20") {
  write_image(folder / "a.png", image);
  write_text(folder / "transforms.json",
             "{" + intrinsics +
                 ", \"frames\": [{\"file_path\": \"a.png\", \"transform_matrix\": "
                 "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}");
}

TEST(Dataset, TransparencyShowsTheBackground) {
  const TempFolder folder;
  Image<std::uint8_t> image(3, 1, 4);
  image.pixels = {200, 100, 0, 255, 200, 100, 0, 0, 200, 100, 0, 51};
  write_one_view(folder.path(), image);
  const auto black = load_dataset(folder.path(), {});
  ASSERT_TRUE(black) << black.error().message();
  EXPECT_THAT(black->train[0].rgb.pixels, testing::ElementsAre(200, 100, 0, 0, 0, 0, 40, 20, 0));
  EXPECT_EQ(black->train[0].rgb.channels, 3);
  const auto white = load_dataset(folder.path(), {.background = glm::vec3(1, 1, 0.5)});
  ASSERT_TRUE(white);
  EXPECT_THAT(white->train[0].rgb.pixels,
              testing::ElementsAre(200, 100, 0, 255, 255, 128, 244, 224, 102));
}

TEST(Dataset, DownscaleAveragesAreasAndScalesTheCameraExactly) {
  const TempFolder folder;
  const auto image = pattern(17, 9);
  write_one_view(folder.path(), image,
                 "\"fl_x\": 20, \"fl_y\": 22, \"cx\": 8, \"cy\": 4.5, \"w\": 17, \"h\": 9");
  const auto data = load_dataset(folder.path(), {.downscale = 2});
  ASSERT_TRUE(data) << data.error().message();
  const Camera& camera = data->train[0].camera;
  EXPECT_EQ(camera.width, 8);
  EXPECT_EQ(camera.height, 4);
  EXPECT_DOUBLE_EQ(camera.fx, 20 * 8.0 / 17);
  EXPECT_DOUBLE_EQ(camera.fy, 22 * 4.0 / 9);
  EXPECT_DOUBLE_EQ(camera.cx, 8 * 8.0 / 17);
  EXPECT_DOUBLE_EQ(camera.cy, 4.5 * 4.0 / 9);

  write_one_view(folder.path(), pattern(16, 8));
  const auto even = load_dataset(folder.path(), {.downscale = 4});
  ASSERT_TRUE(even);
  double sum = 0;
  for (int y = 4; y < 8; ++y)
    for (int x = 8; x < 12; ++x) sum += pattern(16, 8).at(x, y)[1];
  EXPECT_NEAR(even->train[0].rgb.at(2, 1)[1], sum / 16, 0.51);

  expect_failure(load_dataset(folder.path(), {.downscale = 9}), "a.png", "too small");
  expect_failure(load_dataset(folder.path(), {.downscale = 0}), "downscale");
  expect_failure(load_dataset(folder.path(), {.test_every = -1}), "test_every");
}

TEST(Dataset, AnyNumberOfThreadsLoadsTheSame) {
  const TempFolder folder;
  auto model = ten_images();
  model.cameras[0] = {1, 4, "OPENCV", 64, 48, {50, 50, 32, 24, 0.1, -0.05, 1e-3, 0}};
  write_binary(folder.path(), model);
  write_views(folder.path(), model);
  const auto one = load_dataset(folder.path(), {.downscale = 2, .threads = 1});
  const auto four = load_dataset(folder.path(), {.downscale = 2, .threads = 4});
  ASSERT_TRUE(one) << one.error().message();
  ASSERT_TRUE(four);
  for (std::size_t i = 0; i < one->train.size(); ++i) {
    EXPECT_EQ(one->train[i].rgb.pixels, four->train[i].rgb.pixels);
    EXPECT_EQ(one->train[i].camera.fx, four->train[i].camera.fx);
  }
}

TEST(DatasetBadInput, FoldersThatHoldNothing) {
  const TempFolder folder;
  expect_failure(load_dataset(folder.path() / "none", {}), "none", "no such folder");
  expect_failure(load_dataset(folder.path(), {}), folder.path().string(), "expected a COLMAP model",
                 "transforms.json", "images");
  write_text(folder.path() / "file", "x");
  expect_failure(load_dataset(folder.path() / "file", {}), "file", "not a folder");
}

TEST(Views, WithoutColmapTheErrorSaysWhatToInstall) {
  const TempFolder folder;
  write_image(folder.path() / "images" / "a.png", pattern(16, 12));
  const ScopedPath path((folder.path() / "empty").string());
  expect_failure(load_dataset(folder.path(), {}), "images", "install COLMAP");
  EXPECT_FALSE(fs::exists(folder.path() / "colmap")) << "nothing is left behind";
}

/// A program named colmap that does what the text says.
void write_fake_colmap(const fs::path& folder, const std::string& body) {
  write_text(folder / "colmap", "#!/bin/sh\n" + body);
  fs::permissions(folder / "colmap", fs::perms::owner_all);
}

TEST(Views, ColmapIsRunOnceAndItsLargestModelTaken) {
  const TempFolder folder;
  const auto model = ten_images();
  const fs::path data = folder.path() / "my images; $(touch x)";  // No shell may see this.
  write_views(data, model);
  auto few = model;
  few.images.resize(2);
  write_binary(folder.path() / "few", few);
  write_binary(folder.path() / "all", model);
  // Like COLMAP 3.12: the older name of an option is refused.
  write_fake_colmap(folder.path() / "bin", fmt::format(R"(
case "$*" in *SiftExtraction.use_gpu*) exit 1;; esac
echo "$@" >> '{0}/calls'
if [ "$1" = mapper ]; then
  while [ $# -gt 1 ]; do [ "$1" = --output_path ] && out="$2"; shift; done
  cp -r '{0}/few' "$out/0" && cp -r '{0}/all' "$out/1"
fi)",
                                                       folder.path().string()));
  const ScopedPath path((folder.path() / "bin").string() + ":/usr/bin:/bin");
  const auto loaded = load_dataset(data, {});
  ASSERT_TRUE(loaded) << loaded.error().message();
  EXPECT_EQ(loaded->kind, "images (COLMAP)");
  EXPECT_EQ(loaded->train.size(), 8U);
  const std::string calls = read_all(folder.path() / "calls");
  EXPECT_THAT(calls, testing::HasSubstr("--ImageReader.single_camera 1"));
  EXPECT_THAT(calls, testing::HasSubstr("exhaustive_matcher"));
  EXPECT_THAT(calls, testing::HasSubstr("--image_path " + (data / "images").string()));

  ASSERT_TRUE(load_dataset(data, {}));
  EXPECT_EQ(read_all(folder.path() / "calls"), calls) << "the second time nothing is run";
}

TEST(Views, AStepThatFailsIsNamedWithItsLog) {
  const TempFolder folder;
  write_views(folder.path(), ten_images());
  write_fake_colmap(folder.path() / "bin", "echo trouble; [ \"$1\" != exhaustive_matcher ]");
  const ScopedPath path((folder.path() / "bin").string() + ":/usr/bin:/bin");
  expect_failure(load_dataset(folder.path(), {}), "colmap/log.txt", "exhaustive_matcher failed");
  EXPECT_THAT(read_all(folder.path() / "colmap" / "log.txt"), testing::HasSubstr("trouble"));
  EXPECT_FALSE(fs::exists(folder.path() / "colmap" / "sparse"));

  write_fake_colmap(folder.path() / "bin", "exit 0");
  expect_failure(load_dataset(folder.path(), {}), "log.txt", "no cameras");
}

}  // namespace
}  // namespace fluxgs
