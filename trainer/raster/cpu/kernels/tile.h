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

/// Copies between a row-major image plane and a tile, leaving pixels outside the image alone.
template <class Copy>
inline void for_each_pixel_row(const TileArgs& args, const Copy& copy) {
  for (int y = 0; y < kTileSize && args.y0 + y < args.height; ++y) {
    const std::size_t line =
        static_cast<std::size_t>(args.y0 + y) * args.pitch + static_cast<std::size_t>(args.x0);
    for (int bx = 0; bx < 4; ++bx) {
      const int left = args.width - args.x0 - 4 * bx;
      if (left <= 0) break;
      copy(line + static_cast<std::size_t>(4 * bx), 16 * (4 * (y / 4) + bx) + 4 * (y % 4),
           left < 4 ? left : 4);
    }
  }
}

/// Transmittance at the start: 1 inside the image; a fresh plane's 0 outside, where nothing is then
/// drawn.
inline void start_transmittance(const TileArgs& args, TilePlane& t) {
  for_each_pixel_row(args, [&](std::size_t, int at, int count) {
    for (int i = 0; i < count; ++i) t.v[at + i] = 1.0f;
  });
}

/// Blocks with at least one pixel inside the image.
inline std::uint32_t blocks_inside(const TileArgs& args) {
  std::uint32_t blocks = 0;
  for (int b = 0; b < 16; ++b)
    if (args.x0 + 4 * (b % 4) < args.width && args.y0 + 4 * (b / 4) < args.height)
      blocks |= 1u << b;
  return blocks;
}

/// Column and row of every lane of a pack inside its block.
struct LaneOffsets {
  Lanes x[kPacks], y[kPacks];
  LaneOffsets() {
    alignas(64) float xs[16], ys[16];
    for (int i = 0; i < 16; ++i) {
      const int column = i % 4, line = i / 4;
      xs[i] = static_cast<float>(column);
      ys[i] = static_cast<float>(line);
    }
    for (int p = 0; p < kPacks; ++p) {
      x[p] = Lanes::load(xs + kLanes * p);
      y[p] = Lanes::load(ys + kLanes * p);
    }
  }
};

/// A splat's (u, v) over a tile.
struct SplatInTile {
  Lanes u[kPacks], v[kPacks];  ///< in block 0
  float u_per_column, u_per_row, v_per_row;

  SplatInTile(const ProjectedSplat& s, const TileArgs& args, const LaneOffsets& lanes)
      : u_per_column(4.0f * s.xx), u_per_row(4.0f * s.xy), v_per_row(4.0f * s.yy) {
    const Lanes dx(static_cast<float>(args.x0) + 0.5f - s.x);
    const Lanes dy(static_cast<float>(args.y0) + 0.5f - s.y);
    for (int p = 0; p < kPacks; ++p) {
      u[p] = fma(Lanes(s.xx), lanes.x[p] + dx, Lanes(s.xy) * (lanes.y[p] + dy));
      v[p] = Lanes(s.yy) * (lanes.y[p] + dy);
    }
  }
  float u_offset(int block) const {
    return static_cast<float>(block & 3) * u_per_column +
           static_cast<float>(block >> 2) * u_per_row;
  }
  float v_offset(int block) const { return static_cast<float>(block >> 2) * v_per_row; }
};

struct Alpha {
  Lanes raw, alpha;      ///< before and after the limit α_max
  LaneMask contributes;  ///< α ≥ α_min and the pixel is not finished
};

inline Alpha alpha_at(Lanes u, Lanes v, Lanes log2_opacity, Lanes transmittance,
                      const RasterConstants& k) {
  const Lanes exponent = fnma(u, u, fnma(v, v, log2_opacity));
  const Lanes raw = exp2(exponent);
  return {raw, min(raw, Lanes(k.alpha_max)),
          (exponent >= Lanes(k.log2_alpha_min)) & (transmittance >= Lanes(k.transmittance_min))};
}

/// Floats from one colour plane to the next.
inline std::size_t plane_size(const TileArgs& args) {
  return args.pitch * static_cast<std::size_t>(args.height);
}

inline int lowest_bit(std::uint32_t bits) { return __builtin_ctz(bits); }

}  // namespace fluxgs::FLUXGS_ISA
