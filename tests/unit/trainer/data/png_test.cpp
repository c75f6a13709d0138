// Every kind of PNG, and damage that libpng would print about.
#include <array>

#include <png.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "test_files.h"
#include "trainer/data/image_io.h"

namespace fluxgs {
namespace {

using namespace test;

constexpr int kWidth = 37, kHeight = 21;

struct PngKind {
  int color_type = PNG_COLOR_TYPE_RGB, depth = 8;
  bool interlaced = false, transparent_color = false;
};

void append(png_structp png, png_bytep bytes, std::size_t size) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<char*>(bytes), size);
}

/// A palette of 2^depth colors, every second of them half transparent on request.
void set_palette(png_structp png, png_infop info, const PngKind& kind) {
  std::array<png_color, 256> colors{};
  std::array<png_byte, 256> alpha{};
  for (std::size_t i = 0; i < 256; ++i) {
    const auto byte = [&](std::size_t factor) { return static_cast<png_byte>(i * factor); };
    colors[i] = {byte(7), byte(31), byte(101)};
    alpha[i] = i % 2 ? 255 : 128;
  }
  const int used = 1 << kind.depth;
  png_set_PLTE(png, info, colors.data(), used);
  if (kind.transparent_color) png_set_tRNS(png, info, alpha.data(), used, nullptr);
}

std::string png_of(const PngKind& kind) {
  std::string text;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &text, append, nullptr);
  png_set_IHDR(png, info, kWidth, kHeight, kind.depth, kind.color_type,
               kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (kind.color_type == PNG_COLOR_TYPE_PALETTE) set_palette(png, info, kind);
  if (kind.color_type == PNG_COLOR_TYPE_RGB && kind.transparent_color) {
    const png_color_16 color{.index = 0, .red = 0, .green = 1, .blue = 2, .gray = 0};
    png_set_tRNS(png, info, nullptr, 0, &color);
  }
  png_write_info(png, info);
  std::vector<std::vector<png_byte>> rows(kHeight);
  std::vector<png_bytep> pointers;
  for (std::size_t y = 0; y < kHeight; ++y) {
    rows[y].resize(png_get_rowbytes(png, info));
    for (std::size_t i = 0; i < rows[y].size(); ++i) rows[y][i] = static_cast<png_byte>(i + 40 * y);
    pointers.push_back(rows[y].data());
  }
  png_write_image(png, pointers.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return text;
}

/// A chunk with a wrong checksum before the pixels.
std::string with_broken_chunk(std::string png, const std::string& name) {
  const std::string chunk = std::string("\0\0\0\4", 4) + name + "abcd" + "\1\2\3\4";
  return png.insert(png.find("IDAT") - 4, chunk);
}

TEST(Png, EveryKindHasThePixelsOfOpenCv) {
  const TempFolder folder;
  const fs::path file = folder.path() / "a.png";
  std::vector<PngKind> kinds;
  for (const int depth : {1, 2, 4, 8, 16}) kinds.push_back({PNG_COLOR_TYPE_GRAY, depth});
  for (const int depth : {1, 2, 4, 8}) kinds.push_back({PNG_COLOR_TYPE_PALETTE, depth});
  for (const int depth : {8, 16})
    for (const int type : {PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA})
      kinds.push_back({type, depth});
  kinds.push_back({PNG_COLOR_TYPE_PALETTE, 8, false, true});
  kinds.push_back({PNG_COLOR_TYPE_RGB, 8, false, true});
  for (PngKind kind : kinds)
    for (const bool interlaced : {false, true}) {
      SCOPED_TRACE(fmt::format("type {} depth {}{}", kind.color_type, kind.depth,
                               interlaced ? " interlaced" : ""));
      kind.interlaced = interlaced;
      write_text(file, png_of(kind));
      const auto image = read_image(file);
      ASSERT_TRUE(image) << image.error().message();
      cv::Mat expected = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
      if (expected.depth() == CV_16U) expected.convertTo(expected, CV_8U, 1.0 / 257.0);
      cv::cvtColor(expected, expected,
                   expected.channels() == 1   ? cv::COLOR_GRAY2RGB
                   : expected.channels() == 3 ? cv::COLOR_BGR2RGB
                                              : cv::COLOR_BGRA2RGBA);
      ASSERT_EQ(image->channels, expected.channels());
      EXPECT_TRUE(std::equal(image->pixels.begin(), image->pixels.end(), expected.data));
    }
}

TEST(Png, DamageBesideThePixelsIsNoDamage) {
  const TempFolder folder;
  const fs::path file = folder.path() / "a.png";
  const std::string whole = png_of({});
  write_text(file, whole);
  const auto expected = read_image(file);
  ASSERT_TRUE(expected);
  for (const char* name : {"tEXt", "iCCP", "gAMA"}) {
    write_text(file, with_broken_chunk(whole, name));
    testing::internal::CaptureStderr();
    const auto image = read_image(file);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    ASSERT_TRUE(image) << image.error().message();
    EXPECT_EQ(image->pixels, expected->pixels);
  }
}

TEST(PngBadInput, DamagedPixelsAreNamedInOneLine) {
  const TempFolder folder;
  const fs::path file = folder.path() / "a.png";
  std::string whole = png_of({});
  whole[whole.find("IDAT") + 30] ^= 1;
  write_text(file, whole);
  testing::internal::CaptureStderr();
  const auto image = read_image(file);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  expect_failure(image, "a.png: the image is corrupt: ");
}

}  // namespace
}  // namespace fluxgs
