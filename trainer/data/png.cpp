#include "trainer/data/png.h"

#include <algorithm>
#include <csetjmp>
#include <vector>

#include <png.h>

namespace fluxgs {
namespace {

/// The first error of libpng, left by longjmp.
struct PngFailure {
  std::jmp_buf leave;
  char text[128];
};

void fail_png(png_structp png, png_const_charp message) {
  auto* failure = static_cast<PngFailure*>(png_get_error_ptr(png));
  std::string_view text(message);
  text = text.substr(0, sizeof(failure->text) - 1);
  *std::ranges::copy(text, failure->text).out = '\0';
  std::longjmp(failure->leave, 1);
}

void drop_warning(png_structp /*png*/, png_const_charp /*message*/) {}

void read_from_span(png_structp png, png_bytep out, std::size_t size) {
  auto* left = static_cast<std::span<const std::byte>*>(png_get_io_ptr(png));
  if (size > left->size()) png_error(png, "it ends too early");
  std::copy_n(reinterpret_cast<png_const_bytep>(left->data()), size, out);
  *left = left->subspan(size);
}

/// Every kind of pixels to RGB or RGBA of 8 bits.
void ask_for_rgb8(png_structp png, png_infop info) {
  png_set_expand(png);
  png_set_scale_16(png);
  png_set_gray_to_rgb(png);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
}

/// No object with a destructor may live in a frame that longjmp leaves: image and rows belong to
/// the caller.
bool decode(png_structp png, png_infop info, PngFailure& failure, Image<std::uint8_t>& image,
            std::vector<png_bytep>& rows) {
  if (setjmp(failure.leave)) return false;
  png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
  png_read_info(png, info);
  ask_for_rgb8(png, info);
  image = Image<std::uint8_t>(static_cast<int>(png_get_image_width(png, info)),
                              static_cast<int>(png_get_image_height(png, info)),
                              png_get_channels(png, info));
  rows.resize(static_cast<std::size_t>(image.height));
  for (int y = 0; y < image.height; ++y) rows[static_cast<std::size_t>(y)] = image.at(0, y);
  png_read_image(png, rows.data());
  png_read_end(png, nullptr);
  return true;
}

}  // namespace

std::expected<Image<std::uint8_t>, std::string> decode_png(std::span<const std::byte> bytes) {
  PngFailure failure{};
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &failure, fail_png, drop_warning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  Image<std::uint8_t> image;
  std::vector<png_bytep> rows;
  bool decoded = false;
  if (info) {
    png_set_read_fn(png, &bytes, read_from_span);
    decoded = decode(png, info, failure, image, rows);
  }
  png_destroy_read_struct(&png, &info, nullptr);
  if (decoded) return image;
  return std::unexpected(std::string(failure.text[0] ? failure.text : "libpng cannot be started"));
}

}  // namespace fluxgs
