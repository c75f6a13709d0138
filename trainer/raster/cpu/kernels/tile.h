// What the forward and the backward pass share: the pixels of a tile in block order and the one
// definition of α, so that the backward pass replays the forward pass bit for bit.
#pragma once

#include "trainer/raster/cpu/kernels.h"
#include "trainer/simd/lanes.h"

namespace fluxgs::FLUXGS_ISA {

/// Packs of lanes per 4×4 block.
inline constexpr int kPacks = 16 / kLanes;
inline constexpr int kRowsPerPack = 4 / kPacks;

/// Tile pixels are stored block by block, 16 pixels (row-major) each: index 16·block + 4·y + x.
struct TilePlane {
  alignas(64) float v[kTilePixels] = {};
  Lanes load(int block, int pack) const { return Lanes::load(v + 16 * block + kLanes * pack); }
  void store(int block, int pack, Lanes x) { x.store(v + 16 * block + kLanes * pack); }
};

/// Four pixels of a row of a block.
using Quad = hn::Full128<float>;
inline constexpr Quad kQuad{};

/// Calls copy(offset in an image plane, index in a tile plane) for every four pixels of the tile's
/// rows that lie inside the image. Image planes are padded to whole tiles, with zeros.
template <class Copy>
inline void for_each_quad(const TileArgs& args, const Copy& copy) {
  for (int y = 0; y < kTileSize && args.y0 + y < args.height; ++y) {
    const std::size_t line =
        static_cast<std::size_t>(args.y0 + y) * args.pitch + static_cast<std::size_t>(args.x0);
    for (int bx = 0; bx < 4; ++bx)
      copy(line + static_cast<std::size_t>(4 * bx), 16 * (4 * (y / 4) + bx) + 4 * (y % 4));
  }
}

/// Transmittance at the start: 1 inside the image; a fresh plane's 0 outside, where nothing is then
/// drawn.
inline void start_transmittance(const TileArgs& args, TilePlane& t) {
  const int columns = args.width - args.x0, rows = args.height - args.y0;
  for (int i = 0; i < kTilePixels; ++i) {
    const int block = i / 16, x = 4 * (block % 4) + i % 4, y = 4 * (block / 4) + i % 16 / 4;
    t.v[i] = x < columns && y < rows ? 1.0f : 0.0f;
  }
}

/// Blocks with at least one pixel inside the image.
inline std::uint32_t blocks_inside(const TileArgs& args) {
  std::uint32_t blocks = 0;
  for (int b = 0; b < 16; ++b)
    if (args.x0 + 4 * (b % 4) < args.width && args.y0 + 4 * (b / 4) < args.height)
      blocks |= 1u << b;
  return blocks;
}

/// Column and row of every pixel of a tile, in block order.
struct TilePixels {
  TilePlane x, y;
  constexpr TilePixels() {
    for (int i = 0; i < kTilePixels; ++i) {
      x.v[i] = static_cast<float>(4 * (i / 16 % 4) + i % 4);
      y.v[i] = static_cast<float>(4 * (i / 64) + i % 16 / 4);
    }
  }
};
inline constexpr TilePixels kTilePixel;

/// What a splat's (u, v) and α need over a tile.
struct SplatInTile {
  Lanes xx, xy, yy, u, v;  ///< the factor; (u, v) at the tile's first pixel
  Lanes log2_opacity;

  SplatInTile(const ProjectedSplat& s, const TileArgs& args)
      : xx(s.xx), xy(s.xy), yy(s.yy), log2_opacity(s.log2_opacity) {
    const float dx = static_cast<float>(args.x0) + 0.5f - s.x;
    const float dy = static_cast<float>(args.y0) + 0.5f - s.y;
    u = Lanes(s.xx * dx + s.xy * dy);
    v = Lanes(s.yy * dy);
  }
  Lanes u_at(int block, int pack) const {
    return fma(xx, kTilePixel.x.load(block, pack), fma(xy, kTilePixel.y.load(block, pack), u));
  }
  Lanes v_at(int block, int pack) const { return fma(yy, kTilePixel.y.load(block, pack), v); }
  /// log₂ of α before it is limited
  Lanes exponent(Lanes u_pixel, Lanes v_pixel) const {
    return fnma(u_pixel, u_pixel, fnma(v_pixel, v_pixel, log2_opacity));
  }
};

/// α ≥ α_min and the pixel is not finished.
inline LaneMask contributes(Lanes exponent, Lanes transmittance, const RasterConstants& k) {
  return (exponent >= Lanes(k.log2_alpha_min)) & (transmittance >= Lanes(k.transmittance_min));
}

/// The splats of a tile lie anywhere in memory: asks for one some entries before it is needed.
inline void prefetch_splat(const TileArgs& args, std::uint32_t e) {
  constexpr std::uint32_t kAhead = 4;
  if (e + kAhead < args.count) __builtin_prefetch(args.splats + args.entries[e + kAhead].splat);
}

/// Lanes i, i + 4, i + 8, … of a pack added up, for i = 0…3.
template <class D>
inline hn::Vec<Quad> quad_sum(D d, hn::Vec<D> v) {
  if constexpr (hn::MaxLanes(d) == 4) {
    return v;
  } else {
    const hn::Half<D> half;
    return quad_sum(half, hn::Add(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  }
}

/// Floats from one colour plane to the next.
inline std::size_t plane_size(const TileArgs& args) {
  return args.pitch * static_cast<std::size_t>(args.height);
}

inline int lowest_bit(std::uint32_t bits) { return __builtin_ctz(bits); }

}  // namespace fluxgs::FLUXGS_ISA
