// The inside of a .glb: the input, JSON up to the first zero and BIN behind it, gets sound framing
// before it is read, so that changes to it need not agree with the lengths.
#include <algorithm>
#include <string_view>

#include "fluxgs/io/gltf.h"
#include "glb_allowance.h"
#include "harness.h"
#include "io/gltf/glb_container.h"

namespace fluxgs::fuzz {
namespace {

void put(Bytes& out, std::size_t value) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::byte>(value >> shift));
}

std::size_t padded(std::size_t size) { return (size + 3) / 4 * 4; }

void put_chunk(Bytes& out, Input content, unsigned type, char padding) {
  put(out, padded(content.size()));
  put(out, type);
  out.insert(out.end(), content.begin(), content.end());
  out.resize(padded(out.size()), static_cast<std::byte>(padding));
}

Bytes framed(Input json, Input bin) {
  Bytes out;
  for (const char c : io::kGlbMagic) out.push_back(static_cast<std::byte>(c));
  put(out, 2);
  put(out, io::kGlbHeader + 2 * io::kGlbChunkHeader + padded(json.size()) + padded(bin.size()));
  put_chunk(out, json, io::kGlbJson, ' ');
  put_chunk(out, bin, io::kGlbBin, 0);
  return out;
}

}  // namespace

FLUXGS_FUZZ_TARGET(glb_parts) {
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  const Input json = input.first(std::min(text.find('\0'), input.size()));
  const Input bin = input.subspan(std::min(json.size() + 1, input.size()));
  const Bytes file = framed(json, bin);
  return try_reader(Input(file), kGlbAllowance, [](Input bytes) { return read_glb(bytes, "x"); });
}

}  // namespace fluxgs::fuzz
