#include "trainer/data/image_io.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "fluxgs/io/file.h"
#include "trainer/data/file_bytes.h"
#include "trainer/data/heif.h"
#include "trainer/data/image_header.h"
#include "trainer/data/jpeg.h"
#include "trainer/data/lens.h"
#include "trainer/data/png.h"

namespace fluxgs {
namespace {

constexpr std::uint64_t kLargestFile = 1ULL << 30;  // OpenCV counts the bytes in an int.

Expected<ImageHeader> checked_header(std::span<const std::byte> bytes, const std::string& file) {
  if (bytes.empty()) return fail(file, "", "is empty, expected an image");
  const auto header = parse_image_header(bytes);
  if (!header)
    return fail(file, "",
                "not an image that can be read, expected JPEG, PNG, WebP, TIFF, BMP, HEIC or AVIF");
  if (header->width < 0) return fail(file, "", "the image is truncated: its header is incomplete");
  if (header->refused) return fail(file, "", header->refused);
  // Neither product can overflow: JPEG has 16 bits for a side, PNG 32.
  if (header->width < 1 || header->height < 1 ||
      header->width > kMaxPixels / std::max<std::int64_t>(header->height, 1))
    return fail(file, "header",
                fmt::format("image size {}x{}, expected 1 to {} pixels", header->width,
                            header->height, kMaxPixels));
  return *header;
}

/// To 8 bits and to RGB or RGBA order; empty if the kind of pixels is not known.
cv::Mat to_rgb8(cv::Mat decoded) {
  if (decoded.depth() == CV_16U) decoded.convertTo(decoded, CV_8U, 1.0 / 257.0);
  if (decoded.depth() != CV_8U) return {};
  cv::Mat rgb;
  switch (decoded.channels()) {
    case 1:
      cv::cvtColor(decoded, rgb, cv::COLOR_GRAY2RGB);
      break;
    case 3:
      cv::cvtColor(decoded, rgb, cv::COLOR_BGR2RGB);
      break;
    case 4:
      cv::cvtColor(decoded, rgb, cv::COLOR_BGRA2RGBA);
      break;
    default:
      break;
  }
  return rgb;
}

/// WebP, TIFF and BMP.
Expected<Image<std::uint8_t>> decode_by_opencv(std::vector<std::byte>& bytes,
                                               const std::string& file) {
  try {
    // IMREAD_UNCHANGED keeps alpha
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8U, bytes.data());
    const cv::Mat decoded = cv::imdecode(encoded, cv::IMREAD_UNCHANGED);
    if (decoded.empty()) return fail(file, "", "the image is corrupt: it cannot be decoded");
    const cv::Mat rgb = to_rgb8(decoded);
    if (rgb.empty())
      return fail(
          file, "",
          "its pixels have an unknown type, expected integers of 8 or 16 bits with 1, 3 or 4 "
          "channels");
    Image<std::uint8_t> image(rgb.cols, rgb.rows, rgb.channels());
    rgb.copyTo(cv::Mat(rgb.rows, rgb.cols, rgb.type(), image.pixels.data()));
    return image;
  } catch (const cv::Exception& e) {
    if (e.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return fail(file, "", "the image is corrupt: it cannot be decoded");
  }
}

Expected<Image<std::uint8_t>> decode(std::vector<std::byte>& bytes, const ImageHeader& header,
                                     const std::string& file) {
  Expected<Image<std::uint8_t>> image;
  // OpenCV turns these alone, and not in all versions
  if (header.format == ImageFormat::kTiff)
    remove_orientation({reinterpret_cast<std::uint8_t*>(bytes.data()), bytes.size()});
  if (header.format == ImageFormat::kJpeg || header.format == ImageFormat::kPng) {
    auto decoded = header.format == ImageFormat::kJpeg ? decode_jpeg(bytes) : decode_png(bytes);
    if (!decoded) return fail(file, "", "the image is corrupt: " + decoded.error());
    image = std::move(*decoded);
  } else {
    image = decode_by_opencv(bytes, file);
  }
  if (image && (image->width != header.width || image->height != header.height))
    return fail(file, "",
                fmt::format("decoded to {}x{}, expected {}x{} as its header says", image->width,
                            image->height, header.width, header.height));
  return image;
}

bool is_heif(std::span<const std::byte> bytes) {
  const auto header = parse_image_header(bytes.first(std::min<std::size_t>(bytes.size(), 4096)));
  return header && header->format == ImageFormat::kHeif;
}

std::uint8_t to_byte(float value) {
  // Written so that NaN becomes 0.
  const float clamped = value > 0.0F ? std::min(value, 1.0F) : 0.0F;
  return static_cast<std::uint8_t>(std::lround(clamped * 255.0F));
}

}  // namespace

Expected<Image<std::uint8_t>> read_image(const std::filesystem::path& file) {
  try {
    auto bytes = read_file(file, kLargestFile);
    if (!bytes) return std::unexpected(bytes.error());
    if (is_heif(*bytes)) return decode_heif(*bytes, file.string());
    const auto header = checked_header(*bytes, file.string());
    if (!header) return std::unexpected(header.error());
    if (header->format != ImageFormat::kJpeg && !header->complete)
      return fail(file.string(), "", "the image is truncated: its end is missing");
    return decode(*bytes, *header, file.string());
  } catch (const std::bad_alloc&) {
    return fail(file.string(), "", "not enough memory to read the image");
  }
}

Expected<ImageOutline> read_image_outline(const std::filesystem::path& file) {
  // Metadata before a JPEG's frame header seldom exceeds this; if it does, read everything.
  constexpr std::size_t kDefault = 1 << 18;
  auto bytes = read_prefix(file, kDefault);
  if (!bytes) return std::unexpected(bytes.error());
  const auto header = parse_image_header(*bytes);
  if (header && header->width < 0 && bytes->size() == kDefault) {
    bytes = read_file(file, kLargestFile);
    if (!bytes) return std::unexpected(bytes.error());
  }
  if (is_heif(*bytes)) {
    auto outline = read_heif_outline(*bytes, file.string());
    if (!outline) return std::unexpected(outline.error());
    return ImageOutline{.size = outline->size, .exif = std::move(outline->exif)};
  }
  const auto checked = checked_header(*bytes, file.string());
  if (!checked) return std::unexpected(checked.error());
  return ImageOutline{.size = {static_cast<int>(checked->width), static_cast<int>(checked->height)},
                      .exif = checked->exif};
}

Image<std::uint8_t> upright(const Image<std::uint8_t>& image, int orientation) {
  if (orientation <= 1) return image;
  const bool swapped = swaps_sides(orientation);
  Image<std::uint8_t> result(swapped ? image.height : image.width,
                             swapped ? image.width : image.height, image.channels);
  const int right = image.width - 1, bottom = image.height - 1;
  for (int y = 0; y < result.height; ++y)
    for (int x = 0; x < result.width; ++x) {
      // Column and row of the stored image: 2 mirrors, 3 turns by 180 degrees, 4 both; 5 to 8 the
      // same with the axes swapped
      const int u = swapped ? y : x, v = swapped ? x : y;
      const bool from_right =
          orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
      const bool from_bottom =
          orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
      std::copy_n(image.at(from_right ? right - u : u, from_bottom ? bottom - v : v),
                  image.channels, result.at(x, y));
    }
  return result;
}

namespace {

Image<std::uint8_t> bytes_of(const Image<float>& image) {
  Image<std::uint8_t> bytes(image.width, image.height, image.channels);
  std::ranges::transform(image.pixels, bytes.pixels.begin(), to_byte);
  return bytes;
}

/// `extension` with its dot, as OpenCV has it.
Expected<std::vector<std::byte>> encode(const std::string& name, const Image<std::uint8_t>& image,
                                        const char* extension, const char* format,
                                        const std::vector<int>& parameters = {}) {
  if (image.width < 1 || image.height < 1 || (image.channels != 3 && image.channels != 4))
    return fail(name, "",
                fmt::format("cannot write an image of {}x{} with {} channels as {}", image.width,
                            image.height, image.channels, format));
  std::vector<std::uint8_t> encoded;
  std::string why;
  try {
    cv::Mat bgr(image.height, image.width, CV_8UC(image.channels));
    const bool alpha = image.channels == 4;
    std::ranges::copy(image.pixels, bgr.data);
    cv::cvtColor(bgr, bgr, alpha ? cv::COLOR_RGBA2BGRA : cv::COLOR_RGB2BGR);
    if (cv::imencode(extension, bgr, encoded, parameters)) {
      const auto bytes = std::as_bytes(std::span(encoded));
      return std::vector<std::byte>(bytes.begin(), bytes.end());
    }
  } catch (const cv::Exception& e) {
    why = ": " + e.err;
  }
  return fail(name, "", fmt::format("the image could not be encoded as {}{}", format, why));
}

}  // namespace

Expected<void> write_png(const std::filesystem::path& file, const Image<std::uint8_t>& image) {
  const auto encoded = encode(file.string(), image, ".png", "PNG");
  if (!encoded) return std::unexpected(encoded.error());
  return write_file_atomic(file, *encoded);
}

Expected<void> write_png(const std::filesystem::path& file, const Image<float>& image) {
  return write_png(file, bytes_of(image));
}

Expected<std::vector<std::byte>> encode_jpeg(const std::string& name, const Image<float>& image,
                                             int quality) {
  return encode(name, bytes_of(image), ".jpg", "JPEG", {cv::IMWRITE_JPEG_QUALITY, quality});
}

}  // namespace fluxgs
