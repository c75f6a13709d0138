// Pixels of a tile in block order and the definition of α, shared by the forward and the backward
// pass, so that the backward pass replays the forward pass bit for bit.
#pragma once

#include "trainer/core/lanes.h"
#include "trainer/raster/cpu/raster_kernels.h"

namespace fluxgs::FLUXGS_ISA {

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

/// Column and row of every pixel in its block, and of every block's first pixel in its tile.
struct PixelOffsets {
  alignas(64) float x[16] = {}, y[16] = {};
  constexpr explicit PixelOffsets(int step) {
    for (int i = 0; i < 16; ++i) {
      x[i] = static_cast<float>(step * (i % 4));
      y[i] = static_cast<float>(step * (i / 4));
    }
  }
};
inline constexpr PixelOffsets kInBlock(1), kBlocks(kBlockSize);

/// A splat's (u, v) over a tile: where each block starts, and what each of its pixels adds.
struct SplatInTile {
  alignas(64) float block_u[16], block_v[16];
  Lanes du[kPacks], dv[kPacks];
  Lanes log2_opacity;

  SplatInTile(const ProjectedSplat& s, const TileArgs& args) : log2_opacity(s.log2_opacity) {
    const float dx = static_cast<float>(args.x0) + 0.5f - s.x;
    const float dy = static_cast<float>(args.y0) + 0.5f - s.y;
    const Lanes xx(s.xx), xy(s.xy), yy(s.yy), u(s.xx * dx + s.xy * dy), v(s.yy * dy);
    for (int p = 0; p < kPacks; ++p) {
      const auto at = [p](const float* offsets) { return Lanes::load(offsets + kLanes * p); };
      fma(xx, at(kBlocks.x), fma(xy, at(kBlocks.y), u)).store(block_u + kLanes * p);
      fma(yy, at(kBlocks.y), v).store(block_v + kLanes * p);
      du[p] = fma(xx, at(kInBlock.x), xy * at(kInBlock.y));
      dv[p] = yy * at(kInBlock.y);
    }
  }
  Lanes u_at(int block, int pack) const { return du[pack] + Lanes(block_u[block]); }
  Lanes v_at(int block, int pack) const { return dv[pack] + Lanes(block_v[block]); }
  /// log₂ of α before it is limited
  Lanes exponent(Lanes u, Lanes v) const { return fnma(u, u, fnma(v, v, log2_opacity)); }
};

/// α ≥ α_min and the pixel is not finished.
inline LaneMask contributes(Lanes exponent, Lanes transmittance, const RasterConstants& k) {
  return (exponent >= Lanes(k.log2_alpha_min)) & (transmittance >= Lanes(k.transmittance_min));
}

/// True if α may have to be limited anywhere. The margin is above the error of exp2().
inline bool may_exceed_limit(const ProjectedSplat& s, const RasterConstants& k) {
  return s.log2_opacity > k.log2_alpha_max - 1e-5f;
}

/// The splats of a tile lie anywhere in memory: asks for one some entries before it is needed.
inline void prefetch_splat(const TileArgs& args, std::uint32_t e) {
  constexpr std::uint32_t kAhead = 4;
  if (e + kAhead < args.count) __builtin_prefetch(args.splats + args.entries[e + kAhead].splat);
}

/// Floats from one colour plane to the next.
inline std::size_t plane_size(const TileArgs& args) {
  return args.pitch * static_cast<std::size_t>(args.height);
}

inline int lowest_bit(std::uint32_t bits) { return __builtin_ctz(bits); }

}  // namespace fluxgs::FLUXGS_ISA
