// Exif data, and photos that lie on their side.
#include <span>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "exif_support.h"
#include "test_files.h"
#include "tiny_colmap.h"
#include "tools/capture/capture.h"
#include "trainer/data/dataset.h"
#include "trainer/data/exif.h"

namespace fluxgs {
namespace {

using namespace test;

Exif parsed(const std::string& tiff) {
  return parse_exif({reinterpret_cast<const std::uint8_t*>(tiff.data()), tiff.size()});
}

std::string phone_tiff(bool little) {
  const TiffWriter w(little);
  return w.file({w.shorts(274, 6), w.text(271, "Maker  "), w.text(272, "Phone 9")},
                {w.rationals(37386, {{425, 100}}), w.shorts(41989, 26)},
                {w.text(1, "S"), w.rationals(2, {{48, 1}, {30, 1}, {3600, 100}}), w.text(3, "E"),
                 w.rationals(4, {{11, 1}, {15, 1}, {0, 1}}), w.rationals(6, {{500, 1}})});
}

TEST(Exif, PhonePhoto) {
  for (const bool little : {true, false}) {
    const Exif exif = parsed(phone_tiff(little));
    EXPECT_EQ(exif.orientation, 6);
    EXPECT_EQ(exif.camera, "Maker Phone 9");
    EXPECT_EQ(exif.focal_mm, 4.25);
    EXPECT_EQ(exif.focal_35mm, 26);
    ASSERT_TRUE(exif.position);
    EXPECT_NEAR(exif.position->x, -48.51, 1e-9);
    EXPECT_NEAR(exif.position->y, 11.25, 1e-9);
    EXPECT_EQ(exif.position->z, 500);
    // 26 of 43.27 mm, on a diagonal of 5,000 pixels
    EXPECT_NEAR(exif.focal_pixels(4000, 3000), 3004.6, 1);
    EXPECT_NEAR(exif.focal_pixels(3000, 4000), 3004.6, 1);
  }
}

TEST(Exif, FocalLengthByTheSensorsPixels) {
  const TiffWriter w;
  const Exif exif = parsed(w.file({},
                                  {w.rationals(37386, {{50, 1}}), w.rationals(41486, {{2000, 1}}),
                                   w.shorts(41488, 3), w.shorts(40962, 4000)},
                                  {}));
  EXPECT_NEAR(exif.focal_pixels(4000, 3000), 50 * 200, 1e-6);
  EXPECT_NEAR(exif.focal_pixels(1600, 1200), 50 * 200 * 0.4, 1e-6);
  EXPECT_EQ(parsed(w.file({}, {w.rationals(37386, {{50, 0}})}, {})).focal_mm, 0);
  EXPECT_EQ(parsed(w.file({}, {w.shorts(41989, 60000)}, {})).focal_pixels(4000, 3000), 0);
  EXPECT_EQ(Exif().focal_pixels(4000, 3000), 0);
}

TEST(ExifBadInput, NoPlaceIsLeftBlank) {
  const TiffWriter w;
  const auto position = [&](std::uint32_t north, std::uint32_t east) {
    return parsed(w.file({}, {},
                         {w.rationals(2, {{north, 1}, {0, 1}, {0, 1}}),
                          w.rationals(4, {{east, 1}, {0, 1}, {0, 1}})}))
        .position;
  };
  EXPECT_TRUE(position(10, 20));
  EXPECT_FALSE(position(0, 0));
  EXPECT_FALSE(position(91, 20));
  EXPECT_FALSE(parsed(w.file({}, {}, {w.rationals(2, {{1, 1}})})).position);
  const std::string whole = phone_tiff(true);
  for (std::size_t length = 0; length < whole.size(); ++length) parsed(whole.substr(0, length));
  for (std::size_t at = 0; at < whole.size(); ++at)
    for (const char value : {'\0', '\xff', '\x7f'}) {
      std::string damaged = whole;
      damaged[at] = value;
      parsed(damaged);
    }
}

// Exporters often keep the sensor's pixels and the Exif tag while poses are those of the upright
// photo. Lossless, so that every pixel can be compared.
TEST(Exif, ACaptureOnItsSideIsTheSameScene) {
  const TempFolder folder;
  capture::CaptureOptions options{.width = 64, .height = 48, .train = 8, .test = 2, .samples = 1};
  ASSERT_TRUE(capture::write_capture(folder.path(), options));
  for (const char* name : {"transforms_train.json", "transforms_test.json"}) {
    std::string json = read_all(folder.path() / name);
    json.insert(json.find('{') + 1, "\"w\": 64, \"h\": 48, ");
    write_text(folder.path() / name, json);
  }
  const auto before = load_dataset(folder.path(), {});
  ASSERT_TRUE(before) << before.error().message();
  int orientation = 5;  // 5 to 8 swap the sides
  for (const auto* views : {&before->train, &before->test})
    for (const View& view : *views) {
      const int inverse = orientation == 6 ? 8 : orientation == 8 ? 6 : orientation;
      write_image(view.path, upright(view.rgb, inverse));
      write_text(view.path, png_with_exif(read_all(view.path), orientation_tiff(orientation)));
      orientation = orientation == 8 ? 5 : orientation + 1;
    }
  const auto after = load_dataset(folder.path(), {});
  ASSERT_TRUE(after) << after.error().message();
  EXPECT_THAT(after->warnings, testing::ElementsAre(testing::HasSubstr("turned as EXIF says")));
  ASSERT_EQ(after->train.size(), before->train.size());
  for (std::size_t i = 0; i < after->train.size(); ++i) {
    EXPECT_EQ(after->train[i].rgb.pixels, before->train[i].rgb.pixels);
    EXPECT_EQ(after->train[i].camera.fx, before->train[i].camera.fx);
  }
}

TEST(Exif, PhotosOnTheirHeadByExifAreUsedAsStoredAndNamed) {
  const TempFolder folder;
  write_binary(folder.path() / "sparse" / "0", ten_images());
  write_views(folder.path(), ten_images());
  const fs::path file = folder.path() / "images" / "b.png";
  const auto stored = load_dataset(folder.path(), {});
  ASSERT_TRUE(stored) << stored.error().message();
  write_text(file, png_with_exif(read_all(file), orientation_tiff(3)));
  const auto data = load_dataset(folder.path(), {});
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->train[0].rgb.pixels, stored->train[0].rgb.pixels);
  EXPECT_THAT(data->warnings,
              testing::ElementsAre(testing::AllOf(testing::HasSubstr("are not turned"),
                                                  testing::HasSubstr("b.png"))));
}

// Photos of either shape are turned if the poses of others are for turned photos.
TEST(Exif, PhotosOnTheirHeadAreTurnedAmongOthersThatAre) {
  const TempFolder folder;
  write_binary(folder.path() / "sparse" / "0", ten_images());
  write_views(folder.path(), ten_images());
  const auto before = load_dataset(folder.path(), {});
  ASSERT_TRUE(before) << before.error().message();
  const auto store = [&](const std::string& name, int orientation, int inverse) {
    const fs::path file = folder.path() / "images" / name;
    write_image(file, upright(*read_image(file), inverse));
    write_text(file, png_with_exif(read_all(file), orientation_tiff(orientation)));
  };
  store("b.png", 6, 8);
  store("c.png", 3, 3);
  const auto after = load_dataset(folder.path(), {});
  ASSERT_TRUE(after) << after.error().message();
  for (std::size_t i = 0; i < after->train.size(); ++i)
    EXPECT_EQ(after->train[i].rgb.pixels, before->train[i].rgb.pixels);
  EXPECT_THAT(after->warnings,
              testing::ElementsAre(testing::AllOf(testing::HasSubstr("turned as EXIF says"),
                                                  testing::HasSubstr("c.png"))));
}

TEST(Exif, TiffIsReadAsStored) {
  const TempFolder folder;
  const Image<std::uint8_t> image = pattern(16, 12);
  const cv::Mat rgb(12, 16, CV_8UC3, const_cast<std::uint8_t*>(image.pixels.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  const fs::path file = folder.path() / "a.tif";
  for (std::uint8_t orientation = 1; orientation <= 8; ++orientation) {
    ASSERT_TRUE(cv::imwrite(file.string(), bgr));
    std::string bytes = read_all(file);
    // An entry of the directory that OpenCV writes: its tag becomes the orientation's
    const std::string planar("\x1c\x01\x03\x00\x01\x00\x00\x00\x01\x00\x00\x00", 12);
    const std::size_t at = bytes.find(planar);
    ASSERT_NE(at, std::string::npos);
    bytes[at] = '\x12';
    bytes[at + 8] = static_cast<char>(orientation);
    write_text(file, bytes);
    EXPECT_EQ(read_image_outline(file)->exif.orientation, orientation);
    const auto read = read_image(file);
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->pixels, image.pixels) << int{orientation};
  }
}

// Without w and h the principal point tells how the photo stands.
TEST(Exif, SizeOfATurnedImageByItsPrincipalPoint) {
  const TempFolder folder;
  write_image(folder.path() / "a.png", pattern(64, 48));
  write_text(folder.path() / "a.png",
             png_with_exif(read_all(folder.path() / "a.png"), orientation_tiff(6)));
  const auto width_for = [&](const char* centre) {
    write_text(folder.path() / "transforms.json",
               std::string("{\"fl_x\": 50, ") + centre +
                   "\"frames\": [{\"file_path\": \"a.png\", \"transform_matrix\": "
                   "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}");
    const auto data = load_dataset(folder.path(), {});
    return data ? data->train.at(0).camera.width : -1;
  };
  EXPECT_EQ(width_for(""), 64);
  EXPECT_EQ(width_for("\"cx\": 31, \"cy\": 25, "), 64);
  EXPECT_EQ(width_for("\"cx\": 25, \"cy\": 31, "), 48);
}

}  // namespace
}  // namespace fluxgs
