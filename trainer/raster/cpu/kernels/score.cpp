// What each splat adds to the pixels of a picture, weighted by maps over the pixels. It replays the
// forward pass of a tile, like backward.cpp.
#include "trainer/raster/cpu/kernels/kernels_isa.h"
#include "trainer/raster/cpu/kernels/tile.h"

namespace fluxgs::FLUXGS_ISA {
namespace {

struct State {
  TilePlane t;  // transmittance
  TilePlane first, second;
};

void load_state(const ScoreArgs& args, State& s) {
  start_transmittance(args.tile, s.t);
  const std::size_t plane = plane_size(args.tile);
  for_each_pixel_row(args.tile, [&](std::size_t pixel, int at, int count) {
    for (int i = 0; i < count; ++i) {
      const float* m = args.maps + pixel + static_cast<std::size_t>(i);
      s.first.v[at + i] = m[0];
      s.second.v[at + i] = m[plane];
    }
  });
}

}  // namespace

void score(const ScoreArgs& args) {
  const TileArgs& tile = args.tile;
  const RasterConstants& k = tile.constants;
  const LaneOffsets lanes;
  State state;
  load_state(args, state);

  std::uint32_t alive = blocks_inside(tile);
  for (std::uint32_t e = 0; e < tile.count; ++e) {
    const TileEntry entry = tile.entries[e];
    const ProjectedSplat& s = tile.splats[entry.splat];
    const SplatInTile in_tile(s, tile, lanes);
    const Lanes log2_opacity(s.log2_opacity);
    Lanes first(0.0f), second(0.0f), contribution(0.0f);
    unsigned pixels = 0;
    for (std::uint32_t blocks = entry.blocks & alive; blocks; blocks &= blocks - 1) {
      const int block = lowest_bit(blocks);
      const Lanes u_offset(in_tile.u_offset(block)), v_offset(in_tile.v_offset(block));
      bool open = false;
      for (int p = 0; p < kPacks; ++p) {
        const Lanes before = state.t.load(block, p);
        const Alpha a =
            alpha_at(in_tile.u[p] + u_offset, in_tile.v[p] + v_offset, log2_opacity, before, k);
        const Lanes share = zero_unless(a.contributes, a.alpha * before);
        const Lanes after = before - share;
        const Lanes weight =
            args.weight == ScoreWeight::alpha ? zero_unless(a.contributes, a.alpha) : share;
        first = fma(weight, state.first.load(block, p), first);
        second = fma(weight, state.second.load(block, p), second);
        contribution += share;
        pixels += static_cast<unsigned>(__builtin_popcount(bits(a.contributes)));
        state.t.store(block, p, after);
        open |= any(after >= Lanes(k.transmittance_min));
      }
      if (!open) alive &= ~(1u << block);
    }
    args.scores[entry.slot] = {sum(first), sum(second), sum(contribution),
                               static_cast<float>(pixels)};
  }
}

}  // namespace fluxgs::FLUXGS_ISA
