// Exact intersection of a splat's ellipse with tiles and their 4×4 blocks (Hanson et al. 2025,
// "Speedy-Splat": spans per row instead of a bounding box).
#include "trainer/raster/cpu/kernels/kernels_isa.h"
#include "trainer/simd/lanes.h"

namespace fluxgs::FLUXGS_ISA {
namespace {

constexpr int kRowPacks = kTileSize / kLanes;

/// The ellipse's extent on each of a tile's 16 pixel rows, padded so that rounding never loses a
/// pixel; empty rows have left > right.
struct Spans {
  Lanes left[kRowPacks], right[kRowPacks];
};

Spans spans(const ProjectedSplat& s, float reach, int y0) {
  alignas(64) float rows[kTileSize];
  for (int i = 0; i < kTileSize; ++i) rows[i] = static_cast<float>(i);
  const Lanes dy0(static_cast<float>(y0) + 0.5f - s.y), center(s.x), yy(s.yy), limit(reach);
  const Lanes slope(s.xy / s.xx), inverse(1.0f / s.xx);
  Spans out;
  for (int p = 0; p < kRowPacks; ++p) {
    const Lanes dy = Lanes::load(rows + p * kLanes) + dy0;
    const Lanes v = yy * dy;
    const Lanes rest = fnma(v, v, limit);
    const LaneMask touched = rest >= limit * Lanes(-1e-4f) - Lanes(1e-4f);
    const Lanes half = sqrt(max(rest, Lanes(0.0f))) * inverse;
    const Lanes shift = slope * dy;
    const Lanes pad = fma(half + abs(shift), Lanes(1e-6f), Lanes(0.01f));
    const Lanes middle = center - shift;
    out.left[p] = select(touched, middle - half - pad, Lanes(1e30f));
    out.right[p] = select(touched, middle + half + pad, Lanes(-1e30f));
  }
  return out;
}

/// Bit i: row i of the tile meets the pixel centres from `from` to `to`.
std::uint32_t rows_meeting(const Spans& s, float from, float to) {
  std::uint32_t rows = 0;
  for (int p = 0; p < kRowPacks; ++p)
    rows |= bits((s.left[p] <= Lanes(to)) & (s.right[p] >= Lanes(from))) << (p * kLanes);
  return rows;
}

std::uint32_t blocks_of(const Spans& s, float x0) {
  std::uint32_t blocks = 0;
  for (int column = 0; column < 4; ++column) {
    const float from = x0 + 4.0f * static_cast<float>(column) + 0.5f;
    std::uint32_t rows = rows_meeting(s, from, from + 3.0f);
    rows |= rows >> 2;  // any row of each group of four
    rows |= rows >> 1;
    blocks |= (rows & 0x1111u) << column;
  }
  return blocks;
}

struct TileRange {
  int first, last;
};

TileRange tile_range(float center, float half, int tiles) {
  const float lo = (center - half - 0.5f) * (1.0f / kTileSize);
  const float hi = (center + half + 0.5f) * (1.0f / kTileSize);
  return {lo > 0 ? static_cast<int>(lo) : 0,
          hi < static_cast<float>(tiles) ? static_cast<int>(hi) : tiles - 1};
}

}  // namespace

std::uint32_t bin(const ProjectedSplat& s, const RasterConstants& k, int tiles_x, int tiles_y,
                  TileBins* out) {
  const TileRange xs = tile_range(s.x, s.half_width, tiles_x);
  const TileRange ys = tile_range(s.y, s.half_height, tiles_y);
  const float reach = s.log2_opacity - k.log2_alpha_min;
  std::uint32_t count = 0;
  for (int ty = ys.first; ty <= ys.last; ++ty) {
    const Spans rows = spans(s, reach, ty * kTileSize);
    for (int tx = xs.first; tx <= xs.last; ++tx) {
      const std::uint32_t blocks = blocks_of(rows, static_cast<float>(tx * kTileSize));
      if (blocks) out[count++] = {static_cast<std::uint32_t>(ty * tiles_x + tx), blocks};
    }
  }
  return count;
}

}  // namespace fluxgs::FLUXGS_ISA
