#include "trainer/data/jpeg_check.h"

#include <csetjmp>
#include <cstdio>  // jpeglib.h needs it first
#include <vector>

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

void message(j_common_ptr info, int level) {
  if (level < 0) complain(info);  // a warning: the data is corrupt
}

/// No object with a destructor may live in a frame that longjmp leaves: the row belongs to the
/// caller.
bool decode(std::span<const std::byte> bytes, Complaint& complaint, std::vector<JSAMPLE>& row) {
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
  jpeg_start_decompress(&info);
  row.resize(static_cast<std::size_t>(info.output_width) *
             static_cast<std::size_t>(info.output_components));
  JSAMPROW rows[] = {row.data()};
  while (info.output_scanline < info.output_height) jpeg_read_scanlines(&info, rows, 1);
  jpeg_finish_decompress(&info);
  jpeg_destroy_decompress(&info);
  return true;
}

}  // namespace

std::optional<std::string> jpeg_damage(std::span<const std::byte> bytes) {
  Complaint complaint{};
  std::vector<JSAMPLE> row;
  if (decode(bytes, complaint, row)) return std::nullopt;
  return std::string(complaint.text);
}

}  // namespace fluxgs
