// The buffers of a glTF document: its BIN chunk, data: URIs, and files beside it.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fluxgs/byte_source.h"
#include "fluxgs/error.h"
#include "io/sog/named_files.h"

namespace fluxgs::io {

/// A copy of a JSON text in which every string that begins with "data:" is `"data:N"`, N its place
/// in `uris`: these may hold a whole scene, which no parser needs to see. `uris` lie in `text`.
std::string take_data_uris(std::string_view text, std::vector<std::string_view>& uris);

/// A buffer as the document announces it.
struct GltfBuffer {
  std::size_t bytes = 0;           ///< byteLength
  std::optional<std::string> uri;  ///< a file's name, or "data:N", see take_data_uris()
};

/// The BIN chunk of a .glb.
struct GltfBin {
  const ByteSource* file = nullptr;
  std::uint64_t at = 0, bytes = 0;  ///< place in the file
};

/// Bytes that buffers may be made of.
struct GltfSource {
  std::optional<GltfBin> bin;
  std::vector<std::string_view> data_uris;  ///< of the document
  NamedFiles files;                         ///< beside the document; may be empty
  std::size_t document = 0;                 ///< bytes of the file that names the others
};

/// A bufferView that lies within its buffer.
struct GltfView {
  std::size_t buffer = 0, offset = 0, bytes = 0;
  bool operator==(const GltfView&) const = default;
  std::size_t end() const { return offset + bytes; }
};

/// Reads a buffer when it is first asked for: nobody needs the files of what is not splats.
class GltfBuffers {
 public:
  GltfBuffers(std::vector<GltfBuffer> buffers, GltfSource source, std::string name)
      : buffers_(std::move(buffers)), source_(std::move(source)), name_(std::move(name)) {}

  /// The byteLength bytes of a buffer; valid as long as this object and what `source` views. An
  /// error if there is no such buffer, if it holds fewer bytes, or if its URI is none of those
  /// above. URIs of files must be plain names (named_files.h), percent-encoded.
  Expected<std::span<const std::byte>> get(std::size_t index);

  /// The number of bytes of a buffer, checked likewise, without reading a BIN chunk.
  Expected<std::size_t> size(std::size_t index);

  /// The bytes of a view, of a BIN chunk these only. They lie in `room` or elsewhere, and stay
  /// until that changes.
  Expected<std::span<const std::byte>> read(const GltfView& view, std::vector<std::byte>& room);

  /// Bytes of the document and of all files read so far.
  std::size_t bytes() const { return source_.document + beside_; }

 private:
  bool is_bin(std::size_t index) const;
  Expected<std::span<const std::byte>> content(std::size_t index, const std::string& field);
  Expected<std::vector<std::byte>> read_uri(const GltfBuffer& buffer, const std::string& field);

  std::vector<GltfBuffer> buffers_;
  GltfSource source_;
  std::string name_;
  std::map<std::string, std::vector<std::byte>> contents_;  ///< of URIs
  std::vector<std::byte> bin_room_;
  std::optional<std::span<const std::byte>> bin_;  ///< once it was read as a whole
  std::size_t beside_ = 0;
};

}  // namespace fluxgs::io
