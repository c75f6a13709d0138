#include "trainer/data/jpeg.h"

#include <csetjmp>
#include <cstdio>  // jpeglib.h needs it first
#include <vector>

#include <jerror.h>
#include <jpeglib.h>

namespace fluxgs {
namespace {

/// libjpeg's error handler: remembers the first complaint and leaves by longjmp.
struct Complaint {
  jpeg_error_mgr base;  // first: libjpeg knows only this part
  std::jmp_buf leave;
  char text[JMSG_LENGTH_MAX];
};

void complain(j_common_ptr info) {
  auto* complaint = reinterpret_cast<Complaint*>(info->err);
  info->err->format_message(info, complaint->text);
  std::longjmp(complaint->leave, 1);
}

/// Warnings have level -1. Most are about headers, and every pixel is there: odd numbers in a scan
/// header (Samsung), an unknown Adobe marker, bytes before a marker, a missing end marker. Errors
/// are those that lose pixels: data that end inside a scan or cannot be decoded, and a progressive
/// image that ends before its last scan.
void message(j_common_ptr info, int level) {
  if (level >= 0) return;
  const bool decodes = info->is_decompressor != 0;
  switch (info->err->msg_code) {
    case JWRN_HIT_MARKER:
    case JWRN_HUFF_BAD_CODE:
    case JWRN_MUST_RESYNC:
    case JWRN_BOGUS_PROGRESSION:
      return complain(info);
    case JWRN_JPEG_EOF:
      if (decodes && reinterpret_cast<j_decompress_ptr>(info)->progressive_mode) complain(info);
      return;
    default:
      // Behind the last of the header's come those of arithmetic coding, which it may not name
      if (info->err->msg_code > JWRN_TOO_MUCH_DATA) complain(info);
  }
}

/// Ink of Adobe's inverted CMYK to RGB.
void cmyk_to_rgb(const std::vector<JSAMPLE>& row, std::uint8_t* rgb) {
  for (std::size_t i = 0; i < row.size(); i += 4, rgb += 3) {
    const int black = row[i + 3];
    for (std::size_t c = 0; c < 3; ++c)
      rgb[c] = static_cast<std::uint8_t>(black - ((255 - row[i + c]) * black >> 8));
  }
}

/// No object with a destructor may live in a frame that longjmp leaves: image and row belong to the
/// caller.
bool decode(std::span<const std::byte> bytes, Complaint& complaint, Image<std::uint8_t>& image,
            std::vector<JSAMPLE>& row) {
  jpeg_decompress_struct info;
  info.err = jpeg_std_error(&complaint.base);
  complaint.base.error_exit = complain;
  complaint.base.emit_message = message;
  if (setjmp(complaint.leave)) {
    jpeg_destroy_decompress(&info);
    return false;
  }
  jpeg_create_decompress(&info);
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&info, TRUE);
  const bool cmyk = info.num_components == 4;
  info.out_color_space = cmyk ? JCS_CMYK : JCS_RGB;
  jpeg_start_decompress(&info);
  image = Image<std::uint8_t>(static_cast<int>(info.output_width),
                              static_cast<int>(info.output_height), 3);
  if (cmyk) row.resize(4 * static_cast<std::size_t>(info.output_width));
  while (info.output_scanline < info.output_height) {
    std::uint8_t* rgb = image.at(0, static_cast<int>(info.output_scanline));
    JSAMPROW rows[] = {cmyk ? row.data() : rgb};
    jpeg_read_scanlines(&info, rows, 1);
    if (cmyk) cmyk_to_rgb(row, rgb);
  }
  jpeg_finish_decompress(&info);
  jpeg_destroy_decompress(&info);
  return true;
}

}  // namespace

std::expected<Image<std::uint8_t>, std::string> decode_jpeg(std::span<const std::byte> bytes) {
  Complaint complaint{};
  Image<std::uint8_t> image;
  std::vector<JSAMPLE> row;
  if (decode(bytes, complaint, image, row)) return image;
  return std::unexpected(std::string(complaint.text));
}

}  // namespace fluxgs
