// Masks and transparency of a data set: which files are found, and what they leave of the pixels.
#include <algorithm>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tiny_colmap.h"
#include "trainer/data/dataset.h"
#include "trainer/data/pyramid.h"

namespace fluxgs {
namespace {

using namespace test;
using Json = nlohmann::json;
using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::HasSubstr;

constexpr int kWidth = 16, kHeight = 12;

/// White, but for a black rectangle: columns [x0, x1), rows [y0, y1).
Image<std::uint8_t> mask(int x0, int x1, int y0, int y1, int width = kWidth, int height = kHeight,
                         int channels = 3) {
  Image<std::uint8_t> image(width, height, channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c) {
        const bool black = x >= x0 && x < x1 && y >= y0 && y < y1;
        image.at(x, y)[c] = black && c < 3 ? 0 : 255;
      }
  return image;
}

/// Black in the left half.
Image<std::uint8_t> left_half() { return mask(0, kWidth / 2, 0, kHeight); }

/// The pixels of a view that do not count, as rows of . and #; empty where the view has no mask.
std::string picture(const Image<std::uint8_t>& used) {
  std::string text;
  for (int y = 0; y < used.height; ++y) {
    for (int x = 0; x < used.width; ++x) text += *used.at(x, y) == 0 ? '#' : '.';
    text += '\n';
  }
  return text;
}

/// Names of the views that have a mask.
std::vector<std::string> masked(const Dataset& data) {
  std::vector<std::string> names;
  for (const auto* views : {&data.train, &data.test})
    for (const View& view : *views)
      if (!view.used.pixels.empty() || !view.alpha.pixels.empty())
        names.push_back(view.camera.name);
  std::ranges::sort(names);
  return names;
}

/// A COLMAP data set of these images, without masks.
void write_colmap(const fs::path& folder, const std::vector<std::string>& names, int width = kWidth,
                  int height = kHeight) {
  TinyModel model;
  model.cameras[0].width = static_cast<std::uint64_t>(width);
  model.cameras[0].height = static_cast<std::uint64_t>(height);
  for (const std::string& name : names)
    model.images.push_back({.name = name, .pose = {1, 0, 0, 0, 0.1, 0.2, 3}});
  write_binary(folder / "sparse" / "0", model);
  write_views(folder, model);
}

/// transforms.json of images/0.png, images/1.png, …, with more fields for each frame.
void write_transforms(const fs::path& folder, const std::vector<Json>& more, Json top = {}) {
  top["fl_x"] = 20;
  for (std::size_t i = 0; i < more.size(); ++i) {
    Json frame = {{"file_path", fmt::format("images/{}.png", i)},
                  {"transform_matrix",
                   {{1, 0, 0, 0.1 * static_cast<double>(i)}, {0, 1, 0, 0}, {0, 0, 1, 0}}}};
    frame.update(more[i]);
    top["frames"].push_back(frame);
    write_image(folder / "images" / fmt::format("{}.png", i), pattern(kWidth, kHeight));
  }
  write_text(folder / "transforms.json", top.dump());
}

Dataset loaded(const fs::path& folder, LoadOptions options = {}) {
  options.test_every = 0;
  auto data = load_dataset(folder, options);
  EXPECT_TRUE(data) << data.error().message();
  return data ? std::move(*data) : Dataset();
}

TEST(Masks, AreFoundByTheNamesThatPeopleGiveThem) {
  const TempFolder folder;
  write_colmap(folder.path(), {"a.png", "B.JPG.png", "c.png", "sub/d.png", "other/d.png", "e.png"});
  EXPECT_TRUE(masked(loaded(folder.path())).empty());
  write_image(folder.path() / "Masks" / "a.png.png", left_half());  // as COLMAP has it
  write_image(folder.path() / "Masks" / "b.jpg.PNG", left_half());  // another case
  write_image(folder.path() / "mask" / "sub" / "d.png", left_half());
  write_image(folder.path() / "mask" / "nobody.png", left_half());
  EXPECT_THAT(masked(loaded(folder.path())),
              testing::ElementsAre("B.JPG.png", "a.png", "sub/d.png"))
      << "other/d.png has none: the mask of sub/d.png is not its own";
  EXPECT_TRUE(masked(loaded(folder.path(), {.masks = MaskUse::off})).empty());
}

TEST(Masks, WithoutAnExtensionOfThePhotoOrWithAnotherOne) {
  const TempFolder folder;
  write_colmap(folder.path(), {"a.png", "b.png"});
  write_image(folder.path() / "masks" / "a.png", left_half());
  const std::vector<int> fine{cv::IMWRITE_JPEG_QUALITY, 100};
  cv::Mat half(kHeight, kWidth, CV_8UC1, 255);
  half.colRange(0, kWidth / 2).setTo(0);
  cv::imwrite((folder.path() / "masks" / "b.jpg").string(), half, fine);
  EXPECT_THAT(masked(loaded(folder.path())), testing::ElementsAre("a.png", "b.png"));
}

TEST(Masks, NamesMayDifferInUnicodeForm) {
  const TempFolder folder;
  write_colmap(folder.path(), {"\u00e9.png", "b.png"});
  write_image(folder.path() / "masks" / "E\u0301.png", left_half());
  EXPECT_THAT(masked(loaded(folder.path())), testing::ElementsAre("\u00e9.png"));
}

TEST(Masks, NerfstudioNamesThemInItsFile) {
  const TempFolder folder;
  write_transforms(folder.path(), {{{"mask_path", "elsewhere/m.png"}},
                                   {{"mask_path", "C:\\data\\elsewhere\\M.png"}},
                                   {{"mask_path", "elsewhere/none.png"}},
                                   {{"mask_path", "1.png"}},
                                   Json::object(),
                                   {{"mask_path", 7}}});
  write_image(folder.path() / "elsewhere" / "m.png", left_half());
  const Dataset data = loaded(folder.path());
  EXPECT_THAT(masked(data), testing::ElementsAre("0.png", "1.png"));
  EXPECT_THAT(data.warnings,
              testing::ElementsAre(AllOf(HasSubstr("mask_path: 2 masks are not there"),
                                         HasSubstr("elsewhere/none.png, 1.png"))))
      << "a photo is never its own mask";
  write_transforms(folder.path(), {Json::object(), {{"mask_path", ""}}},
                   {{"mask_path", "elsewhere/m.png"}});
  EXPECT_THAT(masked(loaded(folder.path())), testing::ElementsAre("0.png"))
      << "one for all frames that say nothing themselves";
}

TEST(Masks, BlackIsIgnoredAndThePhotoStays) {
  const TempFolder folder;
  write_colmap(folder.path(), {"a.png"});
  const auto before = loaded(folder.path()).train[0].rgb.pixels;
  write_image(folder.path() / "masks" / "a.png", mask(2, 5, 3, 10));
  const Dataset data = loaded(folder.path());
  EXPECT_EQ(picture(data.train[0].used), picture(mask(2, 5, 3, 10, kWidth, kHeight, 1)));
  EXPECT_EQ(data.train[0].rgb.pixels, before);
  EXPECT_TRUE(data.train[0].alpha.pixels.empty());
}

TEST(Masks, CarvedTheyAreTransparency) {
  const TempFolder folder;
  write_colmap(folder.path(), {"a.png"});
  write_image(folder.path() / "masks" / "a.png", left_half());
  const Dataset data = loaded(folder.path(), {.background = {1, 0, 0.2F}, .masks = MaskUse::carve});
  const View& view = data.train[0];
  EXPECT_TRUE(view.used.pixels.empty());
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_EQ(*view.alpha.at(x, y), x < kWidth / 2 ? 0 : 255);
      if (x < kWidth / 2) {
        EXPECT_THAT(std::vector<int>(view.rgb.at(x, y), view.rgb.at(x, y) + 3),
                    testing::ElementsAre(255, 0, 51));
      }
    }
}

TEST(Masks, AnotherSizeIsResized) {
  const TempFolder folder;
  write_colmap(folder.path(), {"a.png", "b.png"});
  write_image(folder.path() / "masks" / "a.png",
              mask(0, 4 * kWidth, 0, 24, 8 * kWidth, 8 * kHeight));
  write_image(folder.path() / "masks" / "b.png",
              mask(0, kWidth / 2, 0, 3, kWidth / 2, kHeight / 2));
  const Dataset data = loaded(folder.path());
  EXPECT_EQ(picture(data.train[0].used), picture(mask(0, 8, 0, 3, kWidth, kHeight, 1)));
  EXPECT_EQ(picture(data.train[1].used), picture(mask(0, 16, 0, 6, kWidth, kHeight, 1)));
}

TEST(Masks, AReducedPixelCountsOnlyWhereNearlyAllOfItIsWhite) {
  const TempFolder folder;
  write_colmap(folder.path(), {"a.png"}, 128, 96);
  write_image(folder.path() / "masks" / "a.png", mask(25, 31, 41, 71, 128, 96));
  const Dataset half = loaded(folder.path(), {.downscale = 2});
  EXPECT_EQ(picture(half.train[0].used), picture(mask(12, 16, 20, 36, 64, 48, 1)));
  EXPECT_EQ(picture(halved(loaded(folder.path()).train[0]).used), picture(half.train[0].used));
}

TEST(Masks, AreUndistortedLikeTheirPhotos) {
  const TempFolder folder;
  TinyModel model;
  model.cameras[0] = {1, 4, "OPENCV", 64, 48, {50, 50, 32, 24, -0.2, 0.05, 0.01, -0.02}};
  model.images.push_back({.name = "a.png"});
  write_binary(folder.path() / "sparse" / "0", model);
  // The photo is its own mask: white stays where it counts, black where it does not
  const auto image = mask(20, 31, 9, 37, 64, 48);
  write_image(folder.path() / "images" / "a.png", image);
  write_image(folder.path() / "masks" / "a.png", image);
  const View view = loaded(folder.path()).train[0];
  int black = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      const int value = *view.rgb.at(x, y);
      EXPECT_EQ(*view.used.at(x, y), value >= kCounts ? 255 : 0) << x << " " << y;
      black += value < 128;
    }
  EXPECT_GT(black, 200);
  EXPECT_NE(picture(view.used), picture(mask(20, 31, 9, 37, 64, 48, 1))) << "nothing was undone";
}

/// Pixels as a PNG of some kind, by OpenCV.
void write_as(const fs::path& file, const cv::Mat& pixels, const std::vector<int>& how = {}) {
  fs::create_directories(file.parent_path());
  ASSERT_TRUE(cv::imwrite(file.string(), pixels, how));
}

TEST(Masks, EveryKindOfPngIsUnderstood) {
  const TempFolder folder;
  const std::vector<std::string> names{"bits", "deep", "grey", "labels", "rgba", "soft", "solid"};
  std::vector<std::string> photos;
  for (const auto& name : names) photos.push_back(name + ".png");
  write_colmap(folder.path(), photos);
  cv::Mat white(kHeight, kWidth, CV_8UC1, 255);
  white(cv::Rect(0, 0, kWidth / 2, kHeight)) = 0;
  const auto file = [&](const std::string& name) {
    return folder.path() / "masks" / (name + ".png");
  };
  write_as(file("grey"), white);
  write_as(file("bits"), white, {cv::IMWRITE_PNG_BILEVEL, 1});
  cv::Mat deep, labels = white / 255, soft = white * (140.0 / 255) + 100;
  white.convertTo(deep, CV_16U, 257);
  write_as(file("deep"), deep);
  write_as(file("labels"), labels);                         // 0 and 1
  write_as(file("soft"), cv::Mat(cv::min(soft, 240) - 0));  // 100 and 240
  cv::Mat rgba(kHeight, kWidth, CV_8UC4, cv::Scalar(255, 255, 255, 255));
  rgba(cv::Rect(0, 0, kWidth / 2, kHeight)) = cv::Scalar(255, 255, 255, 0);
  write_as(file("rgba"), rgba);  // white, masked by transparency
  cv::Mat solid(kHeight, kWidth, CV_8UC4, cv::Scalar(255, 255, 255, 255));
  solid(cv::Rect(0, 0, kWidth / 2, kHeight)) = cv::Scalar(0, 0, 0, 255);
  write_as(file("solid"), solid);
  const Dataset data = loaded(folder.path());
  ASSERT_EQ(data.train.size(), names.size());
  for (const View& view : data.train)
    EXPECT_EQ(picture(view.used), picture(mask(0, 8, 0, kHeight, kWidth, kHeight, 1)))
        << view.camera.name;
}

TEST(MasksBadInput, PhotosWithBadMasksAreLeftOutAndNamed) {
  const TempFolder folder;
  write_colmap(folder.path(), {"a.png", "b.png", "c.png", "d.png", "e.png", "f.png", "g.png"});
  write_image(folder.path() / "masks" / "b.png", mask(0, 1, 0, 1, 12, 12));
  Dataset data = loaded(folder.path());
  EXPECT_EQ(data.train.size(), 6U);
  EXPECT_EQ(data.skipped_images, 1U);
  EXPECT_THAT(data.warnings, Contains(AllOf(HasSubstr("masks/b.png"), HasSubstr("is 12x12"),
                                            HasSubstr("shape of its photo, 16x12"))));
  write_text(folder.path() / "masks" / "b.png", "no image");
  EXPECT_THAT(loaded(folder.path()).warnings,
              Contains(AllOf(HasSubstr("masks/b.png"), HasSubstr("not an image"))));
  write_image(folder.path() / "masks" / "b.png", mask(0, kWidth, 0, kHeight));
  write_image(folder.path() / "masks" / "d.png", mask(0, kWidth, 0, kHeight));
  for (const MaskUse use : {MaskUse::automatic, MaskUse::carve}) {
    data = loaded(folder.path(), {.masks = use});
    EXPECT_EQ(data.train.size(), 5U);
    EXPECT_THAT(data.warnings, Contains(AllOf(HasSubstr("masked or transparent everywhere"),
                                              HasSubstr("b.png"), HasSubstr("d.png"))));
  }
}

TEST(MasksBadInput, AllBlackIsAnErrorThatSaysWhatWhiteMeans) {
  const TempFolder folder;
  write_colmap(folder.path(), {"a.png", "b.png"});
  for (const char* name : {"a.png", "b.png"})
    write_image(folder.path() / "masks" / name, mask(0, kWidth, 0, kHeight));
  expect_failure(load_dataset(folder.path(), {}), "a.png", "white is what counts");
}

/// A JPEG with an EXIF orientation: the stored pixels are turned to be shown.
void write_turned(const fs::path& file, int width, int height, int orientation) {
  fs::create_directories(file.parent_path());
  std::vector<unsigned char> jpeg;
  const auto image = pattern(width, height);
  cv::imencode(".jpg",
               cv::Mat(height, width, CV_8UC3, const_cast<std::uint8_t*>(image.pixels.data())),
               jpeg);
  const unsigned char exif[] = {0xFF,
                                0xE1,
                                0,
                                34,
                                'E',
                                'x',
                                'i',
                                'f',
                                0,
                                0,
                                'I',
                                'I',
                                42,
                                0,
                                8,
                                0,
                                0,
                                0,
                                1,
                                0,
                                0x12,
                                0x01,
                                3,
                                0,
                                1,
                                0,
                                0,
                                0,
                                static_cast<unsigned char>(orientation),
                                0,
                                0,
                                0,
                                0,
                                0,
                                0,
                                0};
  jpeg.insert(jpeg.begin() + 2, std::begin(exif), std::end(exif));
  write_text(file, std::string(jpeg.begin(), jpeg.end()));
}

// The photo is stored lying; its mask lies as well, or was made by a program that turns photos
TEST(Masks, AreTurnedLikeTheirPhotos) {
  for (const bool camera_is_upright : {true, false}) {
    const TempFolder folder;
    TinyModel model;
    if (camera_is_upright) model.cameras[0] = {1, 1, "PINHOLE", 12, 16, {20, 20, 6, 8}};
    model.images = {{.name = "a.jpg"}, {.name = "b.jpg"}};
    write_binary(folder.path() / "sparse" / "0", model);
    for (const char* name : {"a.jpg", "b.jpg"})
      write_turned(folder.path() / "images" / name, kWidth, kHeight, 6);
    // Orientation 6: the stored left column is the top row when shown, from right to left
    write_image(folder.path() / "masks" / "a.png", mask(0, 3, 0, 2));
    write_image(folder.path() / "masks" / "b.png", mask(10, 12, 0, 3, 12, 16));
    const Dataset data = loaded(folder.path());
    ASSERT_EQ(data.train.size(), 2U) << data.warnings.front();
    const auto expected =
        camera_is_upright ? mask(10, 12, 0, 3, 12, 16, 1) : mask(0, 3, 0, 2, kWidth, kHeight, 1);
    for (const View& view : data.train)
      EXPECT_EQ(picture(view.used), picture(expected)) << view.camera.name << camera_is_upright;
  }
}

TEST(Transparency, IsKeptBesideTheColoursOverTheBackground) {
  const TempFolder folder;
  write_transforms(folder.path(), {Json::object(), Json::object()});
  Image<std::uint8_t> image(2, 1, 4);
  image.pixels = {200, 100, 0, 255, 200, 100, 0, 51};
  write_image(folder.path() / "images" / "0.png", image);
  image.pixels[7] = 255;
  write_image(folder.path() / "images" / "1.png", image);
  const LoadOptions white{.background = glm::vec3(1)};
  Dataset data = loaded(folder.path(), white);
  EXPECT_THAT(data.train[0].alpha.pixels, testing::ElementsAre(255, 51));
  EXPECT_EQ(data.train[0].background, glm::vec3(1));
  EXPECT_THAT(data.train[0].rgb.pixels, testing::ElementsAre(200, 100, 0, 244, 224, 204));
  EXPECT_TRUE(data.train[1].alpha.pixels.empty()) << "opaque everywhere is opaque";
  data = loaded(folder.path(), {.masks = MaskUse::ignore});
  EXPECT_TRUE(data.train[0].alpha.pixels.empty());
  EXPECT_THAT(data.train[0].used.pixels, testing::ElementsAre(255, 0));
  data = loaded(folder.path(), {.masks = MaskUse::off});
  EXPECT_TRUE(masked(data).empty());
}

// Programs leave any colour below transparent pixels; reducing the photo must not mix it in
TEST(Transparency, ColoursBelowItDoNotLeak) {
  for (const bool distorted : {false, true}) {
    const auto colours = [&](std::uint8_t garbage) {
      const TempFolder folder;
      Json top;
      if (distorted) top["k1"] = 0.05;
      write_transforms(folder.path(), {Json::object()}, top);
      Image<std::uint8_t> image(120, 96, 4);
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
          const bool inside = x >= 37 && x < 82 && y >= 23 && y < 70;
          for (int c = 0; c < 3; ++c) image.at(x, y)[c] = inside ? 80 : garbage;
          image.at(x, y)[3] = inside ? 255 : 0;
        }
      write_image(folder.path() / "images" / "0.png", image);
      return loaded(folder.path(), {.downscale = 3}).train[0].rgb.pixels;
    };
    EXPECT_EQ(colours(0), colours(255)) << distorted;
  }
}

TEST(Masks, ThoseOfOtherNamesAreNamed) {
  const TempFolder folder;
  write_colmap(folder.path(), {"a.png", "b.png"});
  write_image(folder.path() / "masks" / "000.png", left_half());
  const auto data = load_dataset(folder.path(), {.test_every = 0});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_THAT(data->warnings, Contains(HasSubstr("none of its 1 files has the name of a photo")));
  // Beside the photos themselves, too
  fs::rename(folder.path() / "masks", folder.path() / "images" / "masks");
  fs::rename(folder.path() / "images" / "masks" / "000.png",
             folder.path() / "images" / "masks" / "b.png");
  const auto found = load_dataset(folder.path(), {.test_every = 0});
  ASSERT_TRUE(found) << found.error().message();
  EXPECT_THAT(masked(*found), testing::ElementsAre("b.png"));
}

TEST(Masks, AskedForAndMissingIsAWarning) {
  const TempFolder folder;
  write_colmap(folder.path(), {"a.png", "b.png"});
  for (const MaskUse use : {MaskUse::ignore, MaskUse::carve}) {
    const auto data = load_dataset(folder.path(), {.test_every = 0, .masks = use});
    ASSERT_TRUE(data) << data.error().message();
    EXPECT_THAT(data->warnings, Contains(HasSubstr("--masks has no effect")));
  }
  EXPECT_THAT(load_dataset(folder.path(), {.test_every = 0})->warnings,
              testing::Not(Contains(HasSubstr("--masks"))));
}

}  // namespace
}  // namespace fluxgs
