#include "render/projected_splat.h"

#include <array>
#include <bit>
#include <cmath>

#include <glm/packing.hpp>

namespace fluxgs::render {
namespace {

using Words = std::uint32_t;

ProjectedSplat unpack_full(const Words* w) {
  const auto real = [&](int i) { return std::bit_cast<float>(w[i]); };
  return {.centre = {real(0), real(1)},
          .factor = {real(2), real(3), real(4)},
          .level = real(5),
          .color = {glm::unpackHalf2x16(w[6]), glm::unpackHalf2x16(w[7]).x}};
}

ProjectedSplat unpack_half(const Words* w, const glm::vec2& middle) {
  const auto offset = [](Words bits) {  // 19 bits, two's complement, of 1/64 px
    return static_cast<float>(static_cast<std::int32_t>(bits << 13) >> 13) / 64.0F;
  };
  const auto color = [](Words bits) { return static_cast<float>(bits & 0x3FF) / 511.5F; };
  const float opacity = static_cast<float>((w[3] >> 26) | ((w[0] >> 29) << 6)) / 511.0F;
  return {.centre = middle + glm::vec2(offset(w[0]), offset(w[1])),
          .factor = {glm::unpackHalf2x16(w[2]), glm::unpackHalf2x16(w[3] & 0xFFFF).x},
          .level = std::log2(opacity),
          .color = {color(w[0] >> 19), color(w[1] >> 19), color(w[3] >> 16)}};
}

}  // namespace

std::vector<ProjectedSplat> unpack_projected_splats(std::span<const std::uint32_t> words,
                                                    SplatPrecision precision, int width,
                                                    int height) {
  const std::size_t each = projected_splat_bytes(precision) / sizeof(Words);
  const glm::vec2 middle(0.5F * static_cast<float>(width), 0.5F * static_cast<float>(height));
  std::vector<ProjectedSplat> all(words.size() / each);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Words* at = words.data() + each * i;
    all[i] = precision == SplatPrecision::full ? unpack_full(at) : unpack_half(at, middle);
  }
  return all;
}

}  // namespace fluxgs::render
