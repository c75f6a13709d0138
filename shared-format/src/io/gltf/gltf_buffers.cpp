#include "io/gltf/gltf_buffers.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include "fluxgs/sanitize.h"

namespace fluxgs::io {
namespace {

constexpr std::string_view kData = "data:";
// Behind what a document announces, a file may have padding.
constexpr std::size_t kPadding = 4096;

// The position behind the string that begins at text[at] == '"', or the end of the text.
std::size_t end_of_string(std::string_view text, std::size_t at) {
  // A backslash and what it escapes are passed over together
  for (++at; (at = text.find_first_of("\"\\", at)) < text.size(); at += 2)
    if (text[at] == '"') return at + 1;
  return text.size();
}

constexpr auto kDigits = [] {
  std::array<std::int8_t, 256> digits{};
  digits.fill(-1);
  constexpr std::string_view kBase64 =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < kBase64.size(); ++i)
    digits[static_cast<unsigned char>(kBase64[i])] = static_cast<std::int8_t>(i);
  return digits;
}();

// RFC 4648; padding may be missing, and a slash may be escaped as JSON allows.
std::optional<std::vector<std::byte>> decode_base64(std::string_view text) {
  const std::size_t end = text.find_last_not_of('=');
  text = text.substr(0, end == text.npos ? 0 : end + 1);
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  unsigned count = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\' && i + 1 < text.size() && text[i + 1] == '/') continue;
    const int digit = kDigits[static_cast<unsigned char>(text[i])];
    if (digit < 0) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    if ((count += 6) < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> count));
  }
  return bytes;
}

std::optional<std::string> decode_percents(std::string_view uri) {
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      name += uri[i];
      continue;
    }
    unsigned char value = 0;
    const char* digits = uri.data() + i + 1;
    if (uri.size() - i < 3 || std::from_chars(digits, digits + 2, value, 16).ptr != digits + 2)
      return std::nullopt;
    name += static_cast<char>(value);
    i += 2;
  }
  return name;
}

}  // namespace

std::string take_data_uris(std::string_view text, std::vector<std::string_view>& uris) {
  std::string rest;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t quote = std::min(text.find('"', at), text.size());
    rest += text.substr(at, quote - at);
    if (quote == text.size()) break;
    const std::size_t end = end_of_string(text, quote);
    const std::string_view inside = text.substr(quote + 1, end - quote - 1);
    if (inside.starts_with(kData) && inside.ends_with('"')) {
      rest += fmt::format("\"{}{}\"", kData, uris.size());
      uris.push_back(inside.substr(0, inside.size() - 1));
    } else {
      rest += text.substr(quote, end - quote);
    }
    at = end;
  }
  return rest;
}

Expected<std::vector<std::byte>> GltfBuffers::read_uri(const GltfBuffer& buffer,
                                                       const std::string& field) {
  const std::string& uri = *buffer.uri;
  if (uri.starts_with(kData)) {
    std::size_t index = source_.data_uris.size();
    std::from_chars(uri.data() + kData.size(), uri.data() + uri.size(), index);
    if (index >= source_.data_uris.size())
      return fail(name_, field, "is not a data: URI with base64");
    const std::string_view data = source_.data_uris[index];
    const std::size_t comma = data.find(',');
    if (comma == data.npos || !data.substr(0, comma).ends_with(";base64"))
      return fail(
          name_, field,
          fmt::format("\"{}\" has no base64; expected data:...;base64,...", sanitized(data, 40)));
    auto bytes = decode_base64(data.substr(comma + 1));
    if (!bytes) return fail(name_, field, "has characters that are not of base64");
    return std::move(*bytes);
  }
  auto file = decode_percents(uri);
  if (file && file->starts_with("./")) file->erase(0, 2);
  if (!file || !is_plain_name(*file)) return std::unexpected(name_error(name_, field, uri));
  if (!source_.files)
    return fail(name_, field,
                fmt::format("\"{}\" is a file beside this one and is not read from memory; "
                            "expected all data inside",
                            sanitized(uri)));
  auto bytes = source_.files(*file, std::uint64_t{buffer.bytes} + kPadding);
  if (!bytes) return fail(name_, field, bytes.error().message());
  beside_ += bytes->size();
  return bytes;
}

bool GltfBuffers::is_bin(std::size_t index) const {
  return index == 0 && source_.bin && !buffers_.empty() && !buffers_[0].uri;
}

Expected<std::span<const std::byte>> GltfBuffers::content(std::size_t index,
                                                          const std::string& field) {
  const GltfBuffer& buffer = buffers_[index];
  if (is_bin(index)) {
    if (bin_) return *bin_;
    auto read = source_.bin->file->read(source_.bin->at, source_.bin->bytes, bin_room_);
    if (read) bin_ = *read;
    return read;
  }
  if (!buffer.uri) return fail(name_, field, "has no uri, and no BIN chunk of a .glb holds it");
  auto found = contents_.find(*buffer.uri);
  if (found == contents_.end()) {
    auto content = read_uri(buffer, field + ".uri");
    if (!content) return std::unexpected(content.error());
    found = contents_.emplace(*buffer.uri, std::move(*content)).first;
  }
  return found->second;
}

Expected<std::size_t> GltfBuffers::size(std::size_t index) {
  const std::string field = fmt::format("buffers[{}]", index);
  if (index >= buffers_.size()) return fail(name_, field, "does not exist");
  const GltfBuffer& buffer = buffers_[index];
  std::uint64_t held = 0;
  if (is_bin(index)) {
    held = source_.bin->bytes;
  } else {
    const auto bytes = content(index, field);
    if (!bytes) return std::unexpected(bytes.error());
    held = bytes->size();
  }
  if (held < buffer.bytes)
    return fail(name_, field + ".byteLength",
                fmt::format("is {}, but {} {} bytes", buffer.bytes,
                            buffer.uri ? "the URI holds" : "the BIN chunk holds", held));
  return buffer.bytes;
}

Expected<std::span<const std::byte>> GltfBuffers::get(std::size_t index) {
  const auto bytes = size(index);
  if (!bytes) return std::unexpected(bytes.error());
  auto all = content(index, fmt::format("buffers[{}]", index));
  return all ? all->first(*bytes) : all;
}

Expected<std::span<const std::byte>> GltfBuffers::read(const GltfView& view,
                                                       std::vector<std::byte>& room) {
  if (is_bin(view.buffer) && !bin_)
    return source_.bin->file->read(source_.bin->at + view.offset, view.bytes, room);
  const auto all = get(view.buffer);
  return all ? all->subspan(view.offset, view.bytes) : all;
}

}  // namespace fluxgs::io
