#include "io/other_content.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "io/json_text.h"
#include "io/lower_case.h"

namespace fluxgs::io {
namespace {

struct Kind {
  std::string_view begin;  // of the content, lower case
  std::string_view clause;
};

constexpr std::string_view kWebPage =
    "is a web page; a download that failed leaves one under the name of the file";

constexpr auto kKinds = std::to_array<Kind>({
    {"<!doctype", kWebPage},
    {"<html", kWebPage},
    {"<?xml", "is an XML document"},
    {"version https://git-lfs",
     "is a pointer of Git LFS; \"git lfs pull\" fetches the file itself"},
    {"\x89png", "is a PNG image"},
    {"\xff\xd8\xff", "is a JPEG image"},
    {"pk\x03\x04", "is a ZIP archive without a SOG scene; unpack it and open what is inside"},
    {"7z\xbc\xaf\x27\x1c", "is a 7z archive; unpack it and open what is inside"},
    {"rar!", "is a RAR archive; unpack it and open what is inside"},
    {"\x1f\x8b", "is compressed by gzip; unpack it and open what is inside"},
    {"%pdf", "is a PDF document"},
});

bool is_text(std::string_view text) {
  return !text.empty() && std::ranges::all_of(text, [](char c) {
    const auto u = static_cast<unsigned char>(c);
    return u >= 0x20 || c == '\n' || c == '\r' || c == '\t';
  });
}

}  // namespace

std::string describe_other_content(std::span<const std::byte> bytes) {
  constexpr std::size_t kLooked = 512;
  std::string_view text = as_text(bytes.first(std::min(bytes.size(), kLooked)));
  if (std::ranges::all_of(text, [](char c) { return c == 0; })) return "begins with zeros";
  if (is_text(text)) text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  const std::string begin = lower_case(text);
  for (const Kind& kind : kKinds)
    if (begin.starts_with(kind.begin)) return std::string(kind.clause);
  if (begin.starts_with('{') && (begin.contains("\"frames\"") || begin.contains("camera_angle_x") ||
                                 begin.contains("\"fl_x\"")))
    return "is a list of photos with camera poses, from which a scene can be trained";
  return is_text(text) ? "is text" : "";
}

}  // namespace fluxgs::io
