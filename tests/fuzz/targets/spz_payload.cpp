// The inside of SPZ: the input is compressed into a sound file before it is read, so that changes
// to it pass the checksums. It is the 16 bytes of the header, then the unpacked rest; for version 4
// the attributes one after the other, cut where the header says.
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>

#include "fluxgs/io/spz.h"
#include "harness.h"
#include "io/spz/spz_layout.h"
#include "spz_allowance.h"

namespace fluxgs::fuzz {
namespace {

std::uint32_t number_at(Input input, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, input.data() + at, sizeof value);
  return value;
}

template <class T>
void put(Bytes& out, T value) {
  for (std::size_t i = 0; i < sizeof value; ++i) {
    out.push_back(static_cast<std::byte>(value >> 8 * i));
  }
}

// Stored, which is fastest, with a checksum that is right.
Bytes gzip(Input input) {
  constexpr int kGzip = 16 + MAX_WBITS, kStored = 0, kMinMemory = 1;
  z_stream stream{};
  require(deflateInit2(&stream, kStored, Z_DEFLATED, kGzip, kMinMemory, Z_DEFAULT_STRATEGY) == Z_OK,
          "zlib starts");
  Bytes out(deflateBound(&stream, input.size()));
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(input.data()));
  stream.avail_in = static_cast<uInt>(input.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  require(deflate(&stream, Z_FINISH) == Z_STREAM_END, "zlib ends");
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

Bytes zstd(Input input) {
  Bytes out(ZSTD_compressBound(input.size()));
  out.resize(ZSTD_compress(out.data(), out.size(), input.data(), input.size(), 1));
  return out;
}

// Header, table, streams; the streams that the degree asks for, each of what is left for it.
Bytes with_streams(Input input) {
  const std::uint32_t count = number_at(input, 8);
  const int degree = std::to_integer<int>(input[12]) & 3;
  Bytes out(input.begin(), input.begin() + io::kSpzHeader), streams;
  put(out, static_cast<std::uint32_t>(io::kSpzHeader4));
  out.resize(io::kSpzHeader4);
  Input left = input.subspan(io::kSpzHeader);
  std::uint8_t number = 0;
  for (const std::size_t each : io::spz_attribute_bytes(4, degree)) {
    if (count * each == 0) continue;
    const Input attribute = left.first(std::min(left.size(), count * each));
    left = left.subspan(attribute.size());
    const Bytes stream = zstd(attribute);
    put(out, std::uint64_t{stream.size()});
    put(out, std::uint64_t{attribute.size()});
    streams.insert(streams.end(), stream.begin(), stream.end());
    ++number;
  }
  out[15] = static_cast<std::byte>(number);
  out.insert(out.end(), streams.begin(), streams.end());
  return out;
}

}  // namespace

FLUXGS_FUZZ_TARGET(spz_payload) {
  const bool streams = input.size() >= io::kSpzHeader && number_at(input, 4) == 4;
  const Bytes file = streams ? with_streams(input) : gzip(input);
  return try_reader(Input(file), kSpzAllowance, [](Input bytes) {
    auto other = read_spz(bytes, "x", SpzAxes::right_up_back);
    auto scene = read_spz(bytes, "x");
    require(other.has_value() == scene.has_value(), "axes decide nothing but signs");
    return scene;
  });
}

}  // namespace fluxgs::fuzz
