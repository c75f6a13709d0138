// Image files: what comes back, and what is refused.
#include <sys/stat.h>

#include <algorithm>
#include <cstdio>  // jpeglib.h needs it first
#include <cstdlib>

#include <jpeglib.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "exif_support.h"
#include "test_files.h"
#include "trainer/data/image_io.h"

namespace fluxgs {
namespace {

using namespace test;

/// A JPEG of a smooth image, optionally with restart markers or progressive.
std::string jpeg(int width, int height, const std::vector<int>& parameters = {}) {
  auto image = pattern(width, height);
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", cv::Mat(height, width, CV_8UC3, image.pixels.data()), bytes, parameters);
  return {bytes.begin(), bytes.end()};
}

/// A CMYK JPEG, as programs for print write them.
std::string cmyk_jpeg(int width, int height) {
  jpeg_compress_struct info;
  jpeg_error_mgr errors;
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &bytes, &size);
  info.image_width = static_cast<JDIMENSION>(width);
  info.image_height = static_cast<JDIMENSION>(height);
  info.input_components = 4;
  info.in_color_space = JCS_CMYK;
  jpeg_set_defaults(&info);
  jpeg_start_compress(&info, TRUE);
  const auto image = pattern(width, height, 4);
  std::vector<JSAMPLE> row(4 * static_cast<std::size_t>(width));
  for (int y = 0; y < height; ++y) {
    std::copy_n(image.at(0, y), row.size(), row.begin());
    JSAMPROW rows[] = {row.data()};
    jpeg_write_scanlines(&info, rows, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  const std::string text(bytes, bytes + size);
  std::free(bytes);
  return text;
}

std::string grey_jpeg(int width, int height) {
  cv::Mat grey(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) grey.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(x * y);
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", grey, bytes);
  return {bytes.begin(), bytes.end()};
}

TEST(ImageIo, JpegsHaveThePixelsOfOpenCv) {
  const TempFolder folder;
  const std::string file = (folder.path() / "a.jpg").string();
  for (const std::string& bytes :
       {jpeg(61, 47), jpeg(61, 47, {cv::IMWRITE_JPEG_QUALITY, 30}),
        jpeg(61, 47, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}), grey_jpeg(61, 47), cmyk_jpeg(61, 47)}) {
    write_text(file, bytes);
    const auto image = read_image(file);
    ASSERT_TRUE(image) << image.error().message();
    cv::Mat expected = cv::imread(file, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
    cv::cvtColor(expected, expected, cv::COLOR_BGR2RGB);
    ASSERT_EQ(image->width, expected.cols);
    EXPECT_TRUE(std::equal(image->pixels.begin(), image->pixels.end(), expected.data));
  }
}

TEST(ImageIo, PngRoundTrip) {
  const TempFolder folder;
  for (const int channels : {3, 4}) {
    const auto image = pattern(31, 17, channels);
    write_image(folder.path() / "a.png", image);
    const auto back = read_image(folder.path() / "a.png");
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(back->width, 31);
    EXPECT_EQ(back->height, 17);
    EXPECT_EQ(back->channels, channels);
    EXPECT_EQ(back->pixels, image.pixels);
  }
}

TEST(ImageIo, FloatsAreClampedAndRounded) {
  const TempFolder folder;
  Image<float> image(2, 1, 3);
  image.pixels = {-1.0F, 0.5F, 2.0F, NAN, 0.998F, 1.0F / 255};
  ASSERT_TRUE(write_png(folder.path() / "a.png", image));
  EXPECT_THAT(read_image(folder.path() / "a.png")->pixels,
              testing::ElementsAre(0, 128, 255, 0, 254, 1));
}

TEST(ImageIo, GreyPaletteAndSixteenBits) {
  const TempFolder folder;
  const std::string file = (folder.path() / "a.png").string();
  cv::imwrite(file, cv::Mat(2, 3, CV_8UC1, cv::Scalar(77)));
  EXPECT_THAT(read_image(file)->pixels, testing::Each(77));
  EXPECT_EQ(read_image(file)->channels, 3);
  cv::imwrite(file, cv::Mat(2, 3, CV_16UC3, cv::Scalar(0, 32768, 65535)));
  const auto deep = read_image(file);
  ASSERT_TRUE(deep);
  EXPECT_THAT(std::vector<int>(deep->pixels.begin(), deep->pixels.begin() + 3),
              testing::ElementsAre(255, 128, 0));
}

TEST(ImageIo, SizeWithoutDecoding) {
  const TempFolder folder;
  write_image(folder.path() / "a.png", pattern(31, 17));
  write_text(folder.path() / "a.jpg", jpeg(45, 23));
  EXPECT_EQ(read_image_outline(folder.path() / "a.png")->size.width, 31);
  EXPECT_EQ(read_image_outline(folder.path() / "a.png")->size.height, 17);
  EXPECT_EQ(read_image_outline(folder.path() / "a.jpg")->size.width, 45);
  EXPECT_EQ(read_image_outline(folder.path() / "a.jpg")->size.height, 23);
}

TEST(ImageIo, SizeBehindLongMetadata) {
  const TempFolder folder;
  std::string text = jpeg(45, 23);
  std::string segment("\xff\xe2\xff\xff", 4);  // APP2 of 65,535 bytes, as ICC profiles and previews
  segment.resize(2 + 65535, '\x42');
  for (int i = 0; i < 8; ++i) text.insert(2, segment);
  write_text(folder.path() / "a.jpg", text);
  const auto size = read_image_outline(folder.path() / "a.jpg");
  ASSERT_TRUE(size) << size.error().message();
  EXPECT_EQ(size->size.width, 45);
  EXPECT_TRUE(read_image(folder.path() / "a.jpg"));
}

TEST(ImageIo, ExifOrientationIsIgnored) {
  const TempFolder folder;
  std::string text = jpeg(45, 23);
  // APP1 "Exif", big-endian TIFF, one entry: orientation (0x0112) = 6, turn by 90 degrees.
  const std::string tiff("MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0", 26);
  const std::string app1 = std::string("\xff\xe1\0\x22", 4) + std::string("Exif\0\0", 6) + tiff;
  text.insert(2, app1);
  const fs::path file = folder.path() / "a.jpg";
  write_text(file, text);
  ASSERT_EQ(cv::imread(file.string()).rows, 45) << "the tag must be one that decoders heed";
  const auto image = read_image(file);
  ASSERT_TRUE(image) << image.error().message();
  EXPECT_EQ(image->width, 45);
  EXPECT_EQ(image->height, 23);
}

TEST(ImageIo, JpegKindsAreComplete) {
  const TempFolder folder;
  for (const auto& parameters :
       {std::vector<int>{cv::IMWRITE_JPEG_PROGRESSIVE, 1},
        std::vector<int>{cv::IMWRITE_JPEG_RST_INTERVAL, 2}, std::vector<int>{}}) {
    // Trailing bytes, as phones append them, are no fault.
    write_text(folder.path() / "a.jpg", jpeg(64, 48, parameters) + "trailer \xff\xd8");
    const auto image = read_image(folder.path() / "a.jpg");
    EXPECT_TRUE(image) << image.error().message();
  }
}

// Only the end marker of a JPEG may be missing: every pixel is there.
TEST(ImageIoBadInput, CutAtAnyByteIsRefused) {
  const TempFolder folder;
  const fs::path png = folder.path() / "a.png", jpg = folder.path() / "a.jpg";
  write_image(png, pattern(20, 10, 4));
  write_text(jpg, jpeg(20, 10));
  write_text(folder.path() / "p.jpg", jpeg(20, 10, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}));
  for (const fs::path& file : {png, jpg, folder.path() / "p.jpg"}) {
    const std::string whole = read_all(file);
    const auto all = read_image(file);
    ASSERT_TRUE(all) << all.error().message();
    for (std::size_t length = 0; length < whole.size(); ++length) {
      write_text(file, whole.substr(0, length));
      const auto image = read_image(file);
      if (image && file == jpg && length + 2 >= whole.size()) {
        EXPECT_EQ(image->pixels, all->pixels);
        continue;
      }
      ASSERT_FALSE(image) << file << " cut to " << length << " of " << whole.size();
      ASSERT_THAT(image.error().message(), testing::HasSubstr(file.filename().string()));
      (void)read_image_outline(file);
    }
  }
}

// Lossless files of every other format hold the same pixels, and a cut one is refused.
TEST(ImageIo, OtherFormats) {
  const TempFolder folder;
  const Image<std::uint8_t> image = pattern(31, 17);
  const cv::Mat rgb(17, 31, CV_8UC3, const_cast<std::uint8_t*>(image.pixels.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  const std::pair<const char*, std::vector<int>> formats[] = {
      {".webp", {cv::IMWRITE_WEBP_QUALITY, 101}}, {".bmp", {}}, {".tif", {}}};
  for (const auto& [extension, parameters] : formats) {
    std::vector<std::uint8_t> bytes;
    ASSERT_TRUE(cv::imencode(extension, bgr, bytes, parameters)) << extension;
    const std::string whole(bytes.begin(), bytes.end());
    const fs::path file = folder.path() / (std::string("a") + extension);
    write_text(file, whole);
    const auto read = read_image(file);
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->pixels, image.pixels) << extension;
    const auto outline = read_image_outline(file);
    ASSERT_TRUE(outline) << outline.error().message();
    EXPECT_EQ(outline->size.width, 31);
    EXPECT_EQ(outline->size.height, 17);
    for (std::size_t length = 0; length < whole.size(); ++length) {
      write_text(file, whole.substr(0, length));
      const auto cut = read_image(file);
      // Behind the last strip of a TIFF may come what nobody needs
      EXPECT_EQ(cut ? cut->pixels : image.pixels, image.pixels) << extension << " " << length;
      (void)read_image_outline(file);
    }
    for (std::size_t at = 0; at < whole.size(); ++at) {
      std::string changed = whole;
      changed[at] = static_cast<char>(~changed[at]);
      write_text(file, changed);
      (void)read_image_outline(file);
    }
  }
}

// Some Samsung phones name the coefficients 0 to 0 in the scan header of a sequential JPEG, and
// decoders read it all the same.
TEST(ImageIo, HeaderWarningsOfLibjpegAreNoDamage) {
  const TempFolder folder;
  std::string samsung = jpeg(40, 24);
  const std::size_t scan = samsung.find("\xff\xda");
  ASSERT_NE(scan, std::string::npos);
  const std::size_t length = static_cast<unsigned char>(samsung[scan + 3]);
  samsung[scan + 2 + length - 2] = 0;  // Se, before Ah and Al
  write_text(folder.path() / "samsung.jpg", samsung);
  write_text(folder.path() / "plain.jpg", jpeg(40, 24));
  const auto image = read_image(folder.path() / "samsung.jpg");
  ASSERT_TRUE(image) << image.error().message();
  EXPECT_EQ(image->pixels, read_image(folder.path() / "plain.jpg")->pixels);
}

TEST(ImageIo, OrientationIsReadFromExif) {
  const TempFolder folder;
  for (const bool little : {false, true})
    for (int orientation = 1; orientation <= 8; ++orientation) {
      write_text(folder.path() / "a.jpg",
                 jpeg_with_exif(jpeg(40, 24), orientation_tiff(orientation, little)));
      const auto outline = read_image_outline(folder.path() / "a.jpg");
      ASSERT_TRUE(outline) << outline.error().message();
      EXPECT_EQ(outline->exif.orientation, orientation);
      EXPECT_EQ(outline->size.width, 40);
      EXPECT_TRUE(read_image(folder.path() / "a.jpg"));
    }
  const std::string whole = jpeg_with_exif(jpeg(40, 24), orientation_tiff(9));
  for (std::size_t length = 0; length < 60; ++length) {
    write_text(folder.path() / "a.jpg", whole.substr(0, length));
    const auto outline = read_image_outline(folder.path() / "a.jpg");
    EXPECT_EQ(outline ? outline->exif.orientation : 1, 1);
  }
}

// TIFF 6.0, tag 274: where row 0 and column 0 of the stored image are in the upright one.
TEST(ImageIo, UprightUndoesEachOrientation) {
  const Image<std::uint8_t> image = pattern(5, 3);
  const auto at = [](const Image<std::uint8_t>& i, int x, int y) {
    return std::vector(i.at(x, y), i.at(x, y) + 3);
  };
  struct Case {
    int orientation, x, y;  // of the stored pixel (0, 0)
    int along_x, along_y;   // of the stored pixel (1, 0), relative to it
  };
  for (const Case& c :
       {Case{1, 0, 0, 1, 0}, Case{2, 4, 0, -1, 0}, Case{3, 4, 2, -1, 0}, Case{4, 0, 2, 1, 0},
        Case{5, 0, 0, 0, 1}, Case{6, 2, 0, 0, 1}, Case{7, 2, 4, 0, -1}, Case{8, 0, 4, 0, -1}}) {
    const auto turned = upright(image, c.orientation);
    EXPECT_EQ(turned.width, c.orientation >= 5 ? 3 : 5);
    EXPECT_EQ(at(turned, c.x, c.y), at(image, 0, 0)) << c.orientation;
    EXPECT_EQ(at(turned, c.x + c.along_x, c.y + c.along_y), at(image, 1, 0)) << c.orientation;
  }
}

TEST(ImageIoBadInput, JpegDamagedInTheMiddleIsRefused) {
  const TempFolder folder;
  const fs::path file = folder.path() / "a.jpg";
  std::string whole = jpeg(640, 480, {cv::IMWRITE_JPEG_QUALITY, 95});
  ASSERT_GT(whole.size(), 8000u);
  for (std::size_t at = whole.size() / 2; at < whole.size() / 2 + 3000; ++at)
    whole[at] = static_cast<char>(at * at * 31 >> 3);
  write_text(file, whole);
  const auto image = read_image(file);
  ASSERT_FALSE(image);
  EXPECT_THAT(image.error().message(), testing::HasSubstr("a.jpg: the image is corrupt: "));
}

TEST(ImageIoBadInput, HolesAndNoiseNeverCrash) {
  const TempFolder folder;
  const fs::path file = folder.path() / "a.png";
  write_image(file, pattern(20, 10));
  const std::string whole = read_all(file);
  std::size_t refused = 0;
  for (std::size_t at = 8; at < whole.size(); ++at) {
    std::string changed = whole;
    changed[at] = static_cast<char>(~changed[at]);
    write_text(file, changed);
    refused += !read_image(file).has_value();
  }
  EXPECT_GT(refused, whole.size() / 2) << "PNG has checksums";
}

TEST(ImageIoBadInput, WhatIsNoImageIsNamed) {
  const TempFolder folder;
  expect_failure(read_image(folder.path() / "none.png"), "none.png");
  expect_failure(read_image(folder.path()), folder.path().string());
  write_text(folder.path() / "empty.jpg", "");
  expect_failure(read_image(folder.path() / "empty.jpg"), "empty.jpg", "is empty");
  write_text(folder.path() / "text.jpg", "this is no image");
  expect_failure(read_image(folder.path() / "text.jpg"), "text.jpg", "expected JPEG, PNG");
  expect_failure(read_image_outline(folder.path() / "text.jpg"), "expected JPEG, PNG");
  const fs::path pipe = folder.path() / "pipe.png";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  expect_failure(read_image(pipe), "pipe.png");
  expect_failure(read_image_outline(pipe), "pipe.png");
}

TEST(ImageIoBadInput, AnimationsAreRefused) {
  const TempFolder folder;
  const fs::path file = folder.path() / "a.webp";
  const std::string canvas("\x0a\0\0\0\x02\0\0\0\x1f\0\0\x0f\0\0", 14);
  const std::string loop("ANIM\6\0\0\0\0\0\0\0\0\0", 14);
  const std::string body = "WEBPVP8X" + canvas + loop;
  write_text(file,
             "RIFF" + std::string(1, static_cast<char>(body.size())) + std::string(3, '\0') + body);
  expect_failure(read_image(file), "a.webp", "is an animation");
  expect_failure(read_image_outline(file), "a.webp", "is an animation");
}

TEST(ImageIoBadInput, ColorsInCieLabAreRefused) {
  const TempFolder folder;
  const fs::path file = folder.path() / "a.tif";
  std::vector<std::uint8_t> bytes;
  cv::imencode(".tif", cv::Mat(12, 16, CV_8UC3, cv::Scalar(10, 20, 30)), bytes);
  std::string text(bytes.begin(), bytes.end());
  const std::string rgb("\x06\x01\x03\0\x01\0\0\0\x02\0", 10);  // photometric interpretation
  const std::size_t at = text.find(rgb);
  ASSERT_NE(at, text.npos);
  text[at + 8] = 8;
  write_text(file, text);
  expect_failure(read_image(file), "a.tif", "CIELab");
  expect_failure(read_image_outline(file), "a.tif", "CIELab");
}

// The only images that can hold NaN; bytes, which training takes, cannot.
TEST(ImageIoBadInput, ImagesOfFloatsAreRefused) {
  const TempFolder folder;
  for (const char* kind : {".hdr", ".pfm", ".tiff"}) {
    const bool known = kind == std::string(".tiff");
    std::vector<std::uint8_t> bytes;
    cv::imencode(kind, cv::Mat(8, 8, CV_32FC3, cv::Scalar(NAN, 1, INFINITY)), bytes);
    const fs::path file = folder.path() / (std::string("light") + kind);
    write_text(file, std::string(bytes.begin(), bytes.end()));
    expect_failure(read_image(file), file.filename().string(),
                   known ? "8 or 16 bits" : "expected JPEG, PNG");
    if (!known) expect_failure(read_image_outline(file), "expected JPEG, PNG");
  }
}

TEST(ImageIoBadInput, HugeSizesAreRefusedFromTheHeader) {
  const TempFolder folder;
  write_image(folder.path() / "a.png", pattern(20, 10));
  std::string png = read_all(folder.path() / "a.png");
  png.replace(16, 8, std::string("\x7f\xff\xff\xff\x7f\xff\xff\xff", 8));
  write_text(folder.path() / "a.png", png);
  expect_failure(read_image(folder.path() / "a.png"), "2147483647x2147483647", "expected 1 to");
  std::string jpg = jpeg(20, 10);
  const std::size_t frame = jpg.find(std::string("\xff\xc0", 2));
  jpg.replace(frame + 5, 4, "\xff\xff\xff\xff");
  write_text(folder.path() / "a.jpg", jpg);
  expect_failure(read_image(folder.path() / "a.jpg"), "65535x65535");
  jpg.replace(frame + 5, 4, std::string(4, '\0'));
  write_text(folder.path() / "a.jpg", jpg);
  expect_failure(read_image(folder.path() / "a.jpg"), "0x0");
}

TEST(ImageIoBadInput, WritingWhereNothingCanBeWritten) {
  const TempFolder folder;
  expect_failure(write_png(folder.path() / "none" / "a.png", pattern(2, 2)), "a.png");
  expect_failure(write_png(folder.path() / "a.png", Image<std::uint8_t>()), "0x0");
  EXPECT_FALSE(fs::exists(folder.path() / "a.png"));
}

}  // namespace
}  // namespace fluxgs
