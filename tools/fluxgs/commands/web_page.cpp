#include "tools/fluxgs/commands/web_page.h"

#define ZLIB_CONST  // what is read stays
#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <string_view>

#include <fmt/format.h>

namespace fluxgs::cli {
namespace {

constexpr std::string_view kElement = "<flux-gs-viewer></flux-gs-viewer>";
constexpr std::string_view kTitle = "<title>Flux-GS viewer</title>";
constexpr std::string_view kScene = "<!-- scene -->";

/// Of .gz, which browsers unpack themselves.
std::vector<std::byte> gzipped(std::span<const std::byte> bytes) {
  constexpr int kWindow = 15, kGzip = 16, kMemory = 8;
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kWindow + kGzip, kMemory,
                   Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  std::vector<std::byte> packed(deflateBound(&stream, bytes.size()));
  std::size_t in = 0, out = 0;
  int state = Z_OK;
  while (state == Z_OK) {
    constexpr std::size_t kMost = std::size_t{1} << 30;  // the lengths of a z_stream have 32 bits
    const std::size_t part = std::min(kMost, bytes.size() - in);
    stream.next_in = reinterpret_cast<const Bytef*>(bytes.data() + in);
    stream.avail_in = static_cast<uInt>(part);
    const std::size_t room = std::min(kMost, packed.size() - out);
    stream.next_out = reinterpret_cast<Bytef*>(packed.data() + out);
    stream.avail_out = static_cast<uInt>(room);
    state = deflate(&stream, in + part == bytes.size() ? Z_FINISH : Z_NO_FLUSH);
    in += part - stream.avail_in;
    out += room - stream.avail_out;
  }
  deflateEnd(&stream);
  packed.resize(out);
  return packed;
}

std::string attribute(const char* name, const std::string& value) {
  return value.empty() ? "" : fmt::format(" {}=\"{}\"", name, html_escaped(value));
}

std::string element_of(const WebPage& shown) {
  std::string text = "<flux-gs-viewer";
  text += attribute("name", shown.title) + attribute("src", shown.scene);
  text += attribute("poster", shown.poster) + attribute("background", shown.background);
  if (shown.turntable) text += " turntable";
  return text + "></flux-gs-viewer>";
}

/// What chats and search engines show of a link (ogp.me): a picture by its whole address.
std::string head_of(const WebPage& shown) {
  const std::string title = html_escaped(shown.title);
  std::string text = fmt::format(
      "<title>{0}</title>\n<meta property=\"og:title\" content=\"{0}\">\n"
      "<meta property=\"og:type\" content=\"website\">",
      title);
  if (shown.address.empty()) return text;
  const std::string slash = shown.address.ends_with('/') ? "" : "/";
  text += fmt::format("\n<meta property=\"og:url\" content=\"{}\">", html_escaped(shown.address));
  if (!shown.poster.empty() && !shown.poster.starts_with("data:"))
    text += fmt::format("\n<meta property=\"og:image\" content=\"{}\">",
                        html_escaped(shown.address + slash + shown.poster));
  return text;
}

Expected<void> replace(const std::string& file, std::string& page, std::string_view place,
                       const std::string& by) {
  const std::size_t at = page.find(place);
  if (at == std::string::npos)
    return fail(file, "",
                fmt::format("has no \"{}\": it is of another version; run tools/web/build", place));
  page.replace(at, place.size(), by);
  return {};
}

}  // namespace

std::string html_escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < count ? static_cast<std::uint32_t>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

Expected<std::string> page_with(const std::string& file, const std::string& page,
                                const WebPage& shown, std::span<const std::byte> packed) {
  std::string made = page;
  auto done = replace(file, made, kTitle, head_of(shown));
  if (done) done = replace(file, made, kElement, element_of(shown));
  if (done && !packed.empty())
    done = replace(file, made, kScene,
                   fmt::format("<script type=\"text/plain\" id=\"flux-gs-scene\">{}</script>",
                               base64(gzipped(packed))));
  if (!done) return std::unexpected(done.error());
  return made;
}

Expected<std::string> web_viewer_folder() {
  const char* named = std::getenv("FLUXGS_WEB");
  std::string folder = named != nullptr && *named != 0 ? named : FLUXGS_WEB_FOLDER;
  std::error_code ignored;
  if (!folder.empty() &&
      std::filesystem::exists(std::filesystem::path(folder) / "page.html", ignored))
    return folder;
  return fail(folder, "",
              "the viewer for browsers is not there; make it: tools/setup --web, then "
              "tools/web/build, or name its folder in the variable FLUXGS_WEB");
}

}  // namespace fluxgs::cli
