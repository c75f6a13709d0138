// Reading files that somebody else wrote.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs {

/// Whether a path names a regular file that exists; false, too, for names no file can have.
bool is_file(const std::filesystem::path& path);

/// The content of a file as text; the errors of read_file().
Expected<std::string> read_text(const std::filesystem::path& file,
                                std::uint64_t max_bytes = UINT64_MAX);

/// At most `count` bytes from the beginning of a regular file.
Expected<std::vector<std::byte>> read_prefix(const std::filesystem::path& file, std::size_t count);

/// Takes little-endian values off the front of some bytes; never reads past their end.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::size_t remaining() const { return bytes_.size() - position_; }

  template <class T>
    requires std::is_trivially_copyable_v<T>
  std::optional<T> take() {
    if (remaining() < sizeof(T)) return std::nullopt;
    T value;
    std::memcpy(&value, bytes_.data() + position_, sizeof(T));
    position_ += sizeof(T);
    return value;
  }

  /// Characters up to a zero byte, which is consumed as well.
  std::optional<std::string> take_c_string() {
    const auto rest = bytes_.subspan(position_);
    const void* end = rest.empty() ? nullptr : std::memchr(rest.data(), 0, rest.size());
    if (!end) return std::nullopt;
    const auto length = static_cast<std::size_t>(static_cast<const std::byte*>(end) - rest.data());
    std::string text(length, '\0');
    std::memcpy(text.data(), rest.data(), length);
    position_ += length + 1;
    return text;
  }

  bool skip(std::size_t count) {
    if (remaining() < count) return false;
    position_ += count;
    return true;
  }

 private:
  std::span<const std::byte> bytes_;
  std::size_t position_ = 0;
};

}  // namespace fluxgs
