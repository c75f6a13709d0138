// What each splat adds to the pixels of an image, weighted by maps over the pixels. It replays the
// forward pass of a tile, like backward.cpp.
#include "trainer/raster/cpu/kernels/kernels_isa.h"
#include "trainer/raster/cpu/kernels/tile.h"

namespace fluxgs::FLUXGS_ISA {
namespace {

struct State {
  TilePlane t;  // transmittance
  TilePlane first, second;
  TilePlane counts;  // 1 or 0
};

void load_state(const ScoreArgs& args, State& s) {
  start_transmittance(args.tile, s.t);
  const std::size_t plane = plane_size(args.tile);
  for_each_quad(args.tile, [&](std::size_t pixel, int at) {
    hn::Store(hn::Load(kQuad, args.maps + pixel), kQuad, s.first.v + at);
    hn::Store(hn::Load(kQuad, args.maps + pixel + plane), kQuad, s.second.v + at);
    if (args.masked)
      hn::Store(hn::Load(kQuad, args.maps + pixel + 2 * plane), kQuad, s.counts.v + at);
  });
}

}  // namespace

void score(const ScoreArgs& args) {
  const TileArgs& tile = args.tile;
  const RasterConstants& k = tile.constants;
  State state;
  load_state(args, state);

  for (std::uint32_t e = 0; e < tile.count; ++e) {
    prefetch_splat(tile, e);
    const TileEntry entry = tile.entries[e];
    const ProjectedSplat& s = tile.splats[entry.splat];
    const SplatInTile splat(s, tile);
    Lanes first[kPacks], second[kPacks], contribution[kPacks];
    for (int p = 0; p < kPacks; ++p) first[p] = second[p] = contribution[p] = Lanes(0.0f);
    unsigned pixels = 0;
    for (std::uint32_t blocks = entry.blocks; blocks; blocks &= blocks - 1) {
      const int block = lowest_bit(blocks);
      for (int p = 0; p < kPacks; ++p) {
        const Lanes before = state.t.load(block, p);
        const Lanes exponent = splat.exponent(splat.u_at(block, p), splat.v_at(block, p));
        const LaneMask inside = contributes(exponent, before, k);
        const Lanes alpha = zero_unless(inside, min(exp2(exponent), Lanes(k.alpha_max)));
        const Lanes share = alpha * before, after = before - share;
        const LaneMask counted =
            args.masked ? inside & (state.counts.load(block, p) > Lanes(0.0f)) : inside;
        const Lanes weight =
            zero_unless(counted, args.weight == ScoreWeight::alpha ? alpha : share);
        first[p] = fma(weight, state.first.load(block, p), first[p]);
        second[p] = fma(weight, state.second.load(block, p), second[p]);
        contribution[p] += zero_unless(counted, share);
        pixels += static_cast<unsigned>(__builtin_popcount(bits(counted)));
        state.t.store(block, p, after);
      }
    }
    args.scores[entry.slot] = {sum(first), sum(second), sum(contribution),
                               static_cast<float>(pixels)};
  }
}

}  // namespace fluxgs::FLUXGS_ISA
