// Loading folders: what they may be, and pixels.
#include "trainer/data/dataset.h"

#include <set>

#include "tiny_colmap.h"
#include "trainer/data/reduction.h"

namespace fluxgs {
namespace {

using namespace test;

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
  const auto image = pattern(171, 91);
  write_one_view(folder.path(), image,
                 "\"fl_x\": 200, \"fl_y\": 220, \"cx\": 80, \"cy\": 45, \"w\": 171, \"h\": 91");
  const auto data = load_dataset(folder.path(), {.downscale = 2});
  ASSERT_TRUE(data) << data.error().message();
  const Camera& camera = data->train[0].camera;
  EXPECT_EQ(camera.width, 85);
  EXPECT_EQ(camera.height, 45);
  EXPECT_DOUBLE_EQ(camera.fx, 200 * 85.0 / 171);
  EXPECT_DOUBLE_EQ(camera.fy, 220 * 45.0 / 91);
  EXPECT_DOUBLE_EQ(camera.cx, 80 * 85.0 / 171);
  EXPECT_DOUBLE_EQ(camera.cy, 45 * 45.0 / 91);

  write_one_view(folder.path(), pattern(160, 128));
  const auto even = load_dataset(folder.path(), {.downscale = 4});
  ASSERT_TRUE(even);
  double sum = 0;
  for (int y = 4; y < 8; ++y)
    for (int x = 8; x < 12; ++x) sum += pattern(160, 128).at(x, y)[1];
  EXPECT_NEAR(even->train[0].rgb.at(2, 1)[1], sum / 16, 0.51);

  expect_failure(load_dataset(folder.path(), {.downscale = 64}), "a.png", "2x2", "at most 4");
  expect_failure(load_dataset(folder.path(), {.downscale = -1}), "downscale");
  expect_failure(load_dataset(folder.path(), {.test_every = -1}), "test_every");
}

TEST(Dataset, SomeOfManyViewsAreSpreadEvenly) {
  EXPECT_THAT(spread_indices(9, 3), testing::ElementsAre(1, 4, 7));
  EXPECT_THAT(spread_indices(9, 3, 0), testing::ElementsAre(0, 3, 6));
  EXPECT_THAT(spread_indices(9, 3, 0.99), testing::ElementsAre(2, 5, 8));
  EXPECT_THAT(spread_indices(3, 9, 0.99), testing::ElementsAre(0, 1, 2));  // all of them
  EXPECT_THAT(spread_indices(0, 9), testing::IsEmpty());
  for (const std::size_t all : {100U, 255U, 1001U})
    for (const double turn : {0.0, 0.618, 0.999}) {
      const std::vector<std::uint32_t> some = spread_indices(all, 64, turn);
      EXPECT_EQ(std::set(some.begin(), some.end()).size(), 64U) << all;
      EXPECT_LT(some.back(), all);
    }
}

TEST(Dataset, OnlyVeryLargeImagesAreReducedUnasked) {
  EXPECT_EQ(reduced_size({1600, 1194}, 0).width, 1600);
  EXPECT_EQ(reduced_size({1600, 1194}, 0).height, 1194);
  EXPECT_EQ(reduced_size({4032, 3024}, 0).height, 1200);
  EXPECT_EQ(reduced_size({3024, 4032}, 0).width, 1200);
  EXPECT_EQ(reduced_size({1 << 20, 1}, 0).height, 1);
  EXPECT_EQ(reduced_size({4032, 3024}, 1).width, 4032);
  EXPECT_EQ(reduced_size({4032, 3024}, 5).width, 806);

  const TempFolder folder;
  write_one_view(folder.path(), pattern(3200, 40));
  const auto data = load_dataset(folder.path(), {.downscale = 0});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train[0].camera.width, 1600);
  EXPECT_EQ(data->train[0].camera.fx, 10);
  EXPECT_EQ(load_dataset(folder.path(), {.downscale = 1})->train[0].camera.width, 3200);
}

/// Frames of images of these sizes, from places a step apart.
void write_views(const fs::path& folder, const std::vector<ImageSize>& sizes) {
  std::string frames;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    write_image(folder / fmt::format("{}.png", i), pattern(sizes[i].width, sizes[i].height));
    frames += fmt::format(R"({}{{"file_path": "{}.png", "w": {}, "h": {}, "transform_matrix":
                          [[1,0,0,{}],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}})",
                          i > 0 ? "," : "", i, sizes[i].width, sizes[i].height, i);
  }
  write_text(folder / "transforms.json", R"({"fl_x": 80, "frames": [)" + frames + "]}");
}

TEST(Dataset, AnImageTooSmallForTheReductionIsLeftOut) {
  const TempFolder folder;
  write_views(folder.path(), {{80, 64}, {40, 40}, {80, 64}, {80, 64}});
  const auto data = load_dataset(folder.path(), {.downscale = 2, .test_every = 0});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train.size(), 3u);
  EXPECT_EQ(data->skipped_images, 1u);
  EXPECT_THAT(data->warnings,
              testing::Contains(testing::HasSubstr("left out, since --downscale 2")));
  EXPECT_THAT(data->warnings, testing::Contains(testing::HasSubstr("1.png")));
  expect_failure(load_dataset(folder.path(), {.downscale = 4}), "0.png", "20x16", "at most 2");
}

TEST(Dataset, TheOnlyOneBelowIsMeantAndSeveralAreNamed) {
  const TempFolder folder;
  write_views(folder.path() / "a" / "b" / "first", {{40, 32}, {40, 32}});
  write_image(folder.path() / "cover.png", pattern(8, 8));
  const auto one = load_dataset(folder.path(), {.test_every = 0});
  ASSERT_TRUE(one) << one.error().message();
  EXPECT_EQ(one->train.size(), 2u);
  write_views(folder.path() / "second", {{40, 32}, {40, 32}});
  expect_failure(load_dataset(folder.path(), {}), "2 data sets lie below", "a/b/first, second",
                 "name one");
}

TEST(Dataset, OneImageIsNoScene) {
  const TempFolder folder;
  write_one_view(folder.path(), pattern(16, 12));
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_THAT(data->warnings, testing::Contains(testing::HasSubstr("one image only")));
}

TEST(Dataset, ImagesFromOnePlaceOrTwoShowLittle) {
  const TempFolder folder;
  write_views(folder.path(), {{40, 32}, {40, 32}});
  EXPECT_THAT(load_dataset(folder.path(), {})->warnings,
              testing::Contains(testing::HasSubstr("2 images only")));
  write_views(folder.path(), std::vector<ImageSize>(6, {40, 32}));
  EXPECT_TRUE(load_dataset(folder.path(), {})->warnings.empty());
  std::string text = read_all(folder.path() / "transforms.json");
  for (int i = 1; i < 6; ++i) {
    const std::string place = fmt::format("[[1,0,0,{}]", i);
    text.replace(text.find(place), place.size(), "[[1,0,0,0]");
  }
  write_text(folder.path() / "transforms.json", text);
  EXPECT_THAT(load_dataset(folder.path(), {})->warnings,
              testing::Contains(testing::HasSubstr("all cameras are in one place")));
}

// Far from the origin, 32 bits are too few for what lies between the cameras.
TEST(Dataset, CapturesInMetresOfAMapAreMovedToTheOrigin) {
  const TempFolder folder;
  write_views(folder.path(), std::vector<ImageSize>(6, {40, 32}));
  const auto near = load_dataset(folder.path(), {.test_every = 0});
  std::string text = read_all(folder.path() / "transforms.json");
  for (int i = 0; i < 6; ++i) {
    const std::string place = fmt::format("[[1,0,0,{}],[0,1,0,0]", i);
    text.replace(text.find(place), place.size(),
                 fmt::format("[[1,0,0,{}.25],[0,1,0,5400000]", 60'000'000 + i));
  }
  write_text(folder.path() / "transforms.json", text);
  const auto far = load_dataset(folder.path(), {.test_every = 0});
  ASSERT_TRUE(far) << far.error().message();
  EXPECT_THAT(far->warnings, testing::ElementsAre(testing::HasSubstr("moved to the origin")));
  for (std::size_t i = 1; i < 6; ++i) {
    const auto step = [&](const Dataset& data) {
      return data.train[i].camera.center() - data.train[0].camera.center();
    };
    EXPECT_LT(glm::distance(step(*far), step(*near)), 1e-6);
    EXPECT_LT(glm::length(far->train[i].camera.center()), 1024);
  }
}

TEST(Dataset, IntrinsicsThatNoCameraHasAreNamed) {
  const TempFolder folder;
  write_views(folder.path(), std::vector<ImageSize>(6, {40, 32}));
  std::string text = read_all(folder.path() / "transforms.json");
  text.replace(text.find("\"fl_x\": 80"), 10, "\"fl_x\": 0.9, \"cx\": 0.5, \"cy\": 0.5");
  write_text(folder.path() / "transforms.json", text);
  EXPECT_THAT(load_dataset(folder.path(), {})->warnings,
              testing::Contains(testing::HasSubstr("expected pixels, not a fraction")));
  text.replace(text.find("\"cx\": 0.5"), 9, "\"cx\": 0  ");
  write_text(folder.path() / "transforms.json", text);
  EXPECT_THAT(load_dataset(folder.path(), {})->warnings,
              testing::Contains(testing::HasSubstr("principal points in the corner")));
}

TEST(Dataset, ImagesThatAllFailAreCountedAndNamed) {
  const TempFolder folder;
  write_views(folder.path(), std::vector<ImageSize>(5, {40, 32}));
  for (int i = 0; i < 5; ++i) {
    const fs::path file = folder.path() / fmt::format("{}.png", i);
    const std::string whole = read_all(file);
    write_text(file, whole.substr(0, whole.size() - 20));
  }
  expect_failure(load_dataset(folder.path(), {}), "5 of 5 images", "1.png", "3.png and 2 more",
                 "truncated");
}

TEST(Dataset, AnyNumberOfThreadsLoadsTheSame) {
  const TempFolder folder;
  auto model = ten_images();
  model.cameras[0] = {1, 4, "OPENCV", 96, 64, {70, 70, 48, 32, 0.1, -0.05, 1e-3, 0}};
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
  expect_failure(load_dataset(folder.path() / "file", {}), "file", "neither a folder");
}

}  // namespace
}  // namespace fluxgs
