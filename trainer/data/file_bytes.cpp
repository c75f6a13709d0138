#include "trainer/data/file_bytes.h"

#include <cstring>
#include <fstream>
#include <string_view>

#include "fluxgs/io/file.h"

namespace fluxgs {

bool is_file(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error);
}

namespace {

/// UTF-16 and UTF-32, with or without a byte order mark: the second half of a letter is 0.
bool is_wide_text(std::string_view text) {
  return text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff") ||
         text.substr(0, 4).find('\0') != std::string_view::npos;
}

}  // namespace

Expected<std::string> read_text(const std::filesystem::path& file, std::uint64_t max_bytes) {
  const auto bytes = read_file(file, max_bytes);
  if (!bytes) return std::unexpected(bytes.error());
  std::string text(bytes->size(), '\0');
  if (!text.empty()) std::memcpy(text.data(), bytes->data(), text.size());
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  if (is_wide_text(text))
    return fail(file.string(), "", "is text in UTF-16 or UTF-32, expected UTF-8; save it as UTF-8");
  return text;
}

Expected<std::vector<std::byte>> read_prefix(const std::filesystem::path& file, std::size_t count) {
  if (!is_file(file)) return fail(file.string(), "", "no such file, or not a regular one");
  std::vector<std::byte> bytes(count);
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return fail(file.string(), "", "cannot be opened");
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(count));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return bytes;
}

}  // namespace fluxgs
