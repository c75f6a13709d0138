#include "trainer/data/file_bytes.h"

#include <cstring>
#include <fstream>

#include "fluxgs/io/file.h"

namespace fluxgs {

bool is_file(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error);
}

Expected<std::string> read_text(const std::filesystem::path& file, std::uint64_t max_bytes) {
  const auto bytes = read_file(file, max_bytes);
  if (!bytes) return std::unexpected(bytes.error());
  std::string text(bytes->size(), '\0');
  if (!text.empty()) std::memcpy(text.data(), bytes->data(), text.size());
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
