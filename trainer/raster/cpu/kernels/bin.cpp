// Exact intersection of a splat's ellipse with tiles and their 4×4 blocks (Hanson et al. 2025,
// "Speedy-Splat": spans per row instead of a bounding box).
#include "trainer/core/lanes.h"
#include "trainer/raster/cpu/kernels/kernels_isa.h"

namespace fluxgs::FLUXGS_ISA {
namespace {

constexpr int kRowPacks = kTileSize / kLanes;

/// The ellipse's extent on the pixel rows of each row of a tile's blocks, which fills four lanes;
/// padded so that rounding never loses a pixel. Rows that it does not meet have left > right.
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
    out.left[p] = quad_min(select(touched, middle - half - pad, Lanes(1e30f)));
    out.right[p] = quad_max(select(touched, middle + half + pad, Lanes(-1e30f)));
  }
  return out;
}

/// First pixels of the four columns of blocks, for each row of blocks.
alignas(64) constexpr float kColumns[16] = {0, 4, 8, 12, 0, 4, 8, 12, 0, 4, 8, 12, 0, 4, 8, 12};

/// A block counts that lies between a row's left end and another row's right end, too.
std::uint32_t blocks_of(const Spans& s, float x0) {
  const Lanes from = Lanes::load(kColumns) + Lanes(x0 + 0.5f), to = from + Lanes(3.0f);
  std::uint32_t blocks = 0;
  for (int p = 0; p < kRowPacks; ++p)
    blocks |= bits((s.left[p] <= to) & (s.right[p] >= from)) << (p * kLanes);
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

std::uint32_t bin(const ProjectedSplat* splats, std::uint32_t index, const RasterConstants& k,
                  int tiles_x, int tiles_y, TileBin* out) {
  const ProjectedSplat& s = splats[index];
  const TileRange xs = tile_range(s.x, s.half_width, tiles_x);
  const TileRange ys = tile_range(s.y, s.half_height, tiles_y);
  const float reach = s.log2_opacity - k.log2_alpha_min;
  std::uint32_t count = 0;
  for (int ty = ys.first; ty <= ys.last; ++ty) {
    const Spans rows = spans(s, reach, ty * kTileSize);
    for (int tx = xs.first; tx <= xs.last; ++tx) {
      const std::uint32_t blocks = blocks_of(rows, static_cast<float>(tx * kTileSize));
      out[count] = {index, static_cast<std::uint32_t>(ty * tiles_x + tx), blocks};
      count += blocks != 0;  // no branch, which would be mispredicted
    }
  }
  return count;
}

}  // namespace fluxgs::FLUXGS_ISA
