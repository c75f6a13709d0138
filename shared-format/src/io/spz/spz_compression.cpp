#include "io/spz/spz_compression.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "cloud/cloud_memory.h"

namespace fluxgs::io {
namespace {

constexpr int kGzip = 16 + MAX_WBITS;  // zlib: a gzip header and trailer around the data
constexpr int kGzipLevel = 6, kGzipMemory = 9;
constexpr int kZstdLevel = 12;  // as the reference implementation

// zlib counts in 32 bits: feed and drain it in pieces.
class Pieces {
 public:
  Pieces(z_stream& stream, std::span<const std::byte> input, std::span<std::byte> out)
      : stream_(stream), input_(input), out_(out) {
    refill();
  }

  void refill() {
    constexpr std::size_t kMax = std::numeric_limits<uInt>::max();
    if (stream_.avail_in == 0) {
      stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(input_.data()));
      stream_.avail_in = static_cast<uInt>(std::min(input_.size(), kMax));
      input_ = input_.subspan(stream_.avail_in);
    }
    if (stream_.avail_out == 0) {
      stream_.next_out = reinterpret_cast<Bytef*>(out_.data());
      stream_.avail_out = static_cast<uInt>(std::min(out_.size(), kMax));
      out_ = out_.subspan(stream_.avail_out);
    }
  }

  bool fed_all() const { return input_.empty(); }
  std::size_t left_in() const { return input_.size() + stream_.avail_in; }
  std::size_t left_out() const { return out_.size() + stream_.avail_out; }

 private:
  z_stream& stream_;
  std::span<const std::byte> input_;
  std::span<std::byte> out_;
};

}  // namespace

Inflated inflate_gzip(std::span<const std::byte> input, std::span<std::byte> out) {
  Inflated result;
  z_stream stream{};
  if (inflateInit2(&stream, kGzip) != Z_OK) {
    result.damaged = true;
    return result;
  }
  Pieces pieces(stream, input, out);
  int code = Z_OK;
  while (code == Z_OK && pieces.left_out() > 0) {
    pieces.refill();
    code = inflate(&stream, Z_NO_FLUSH);
  }
  result.ended = code == Z_STREAM_END;
  result.damaged = code != Z_STREAM_END && code != Z_OK && code != Z_BUF_ERROR;
  result.written = out.size() - pieces.left_out();
  result.consumed = input.size() - pieces.left_in();
  inflateEnd(&stream);
  return result;
}

Inflated inflate_gzip_start(std::span<const std::byte> input, std::span<std::byte> out) {
  constexpr std::size_t kStart = 4096;
  return inflate_gzip(input.first(std::min(input.size(), kStart)), out);
}

std::string shortfall(const Inflated& got, std::size_t expected) {
  const std::string end = got.damaged ? "is damaged"
                          : got.ended ? "ends"
                                      : "the file is cut off: its data end";
  return fmt::format("{} after {} bytes; expected {}", end, got.written, expected);
}

std::string decompress_zstd(std::span<const std::byte> input, std::span<std::byte> out) {
  const std::size_t size = ZSTD_decompress(out.data(), out.size(), input.data(), input.size());
  if (ZSTD_isError(size)) return ZSTD_getErrorName(size);
  if (size == out.size()) return {};
  return fmt::format("ends after {} of {} bytes", size, out.size());
}

Expected<std::vector<std::byte>> compress_gzip(std::span<const std::byte> input,
                                               const std::string& name) {
  z_stream stream{};
  if (deflateInit2(&stream, kGzipLevel, Z_DEFLATED, kGzip, kGzipMemory, Z_DEFAULT_STRATEGY) !=
      Z_OK) {
    return fail(name, "memory", "out of memory: gzip could not be started");
  }
  auto bytes = allocate_bytes(deflateBound(&stream, input.size()), name);
  if (bytes) {
    Pieces pieces(stream, input, *bytes);
    int code = Z_OK;
    while (code == Z_OK) {
      pieces.refill();
      code = deflate(&stream, pieces.fed_all() ? Z_FINISH : Z_NO_FLUSH);
    }
    bytes->resize(bytes->size() - pieces.left_out());
    if (code != Z_STREAM_END) bytes = fail(name, "gzip", fmt::format("failed with code {}", code));
  }
  deflateEnd(&stream);
  return bytes;
}

Expected<std::vector<std::byte>> compress_zstd(std::span<const std::byte> input,
                                               const std::string& name) {
  auto bytes = allocate_bytes(ZSTD_compressBound(input.size()), name);
  if (!bytes) return bytes;
  const std::size_t size =
      ZSTD_compress(bytes->data(), bytes->size(), input.data(), input.size(), kZstdLevel);
  if (ZSTD_isError(size)) return fail(name, "zstd", ZSTD_getErrorName(size));
  bytes->resize(size);
  return bytes;
}

}  // namespace fluxgs::io
