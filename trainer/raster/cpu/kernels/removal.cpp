// The change of an image's squared error that the removal of each splat alone makes. It replays the
// forward pass of a tile, like backward.cpp.
//
// Without a splat, what lies behind it is seen through 1 instead of 1 − α, and its own colour is
// gone. With B = Σ αT·c over all that lies behind, the background included, a pixel changes by
//   δ = B·α/(1 − α) − αT·c = −α·∂C/∂α,
// and its squared error by Σ (e + δ)² − e² = Σ δ·(δ + 2e) over the channels, e being the error.
// That is exact but for rays that ended early.
#include "trainer/raster/cpu/kernels/kernels_isa.h"
#include "trainer/raster/cpu/kernels/tile.h"

namespace fluxgs::FLUXGS_ISA {
namespace {

struct State {
  TilePlane t;          // transmittance
  TilePlane behind[3];  // B
  TilePlane error[3];   // 2e
  TilePlane counts;     // 1 or 0
};

void load_state(const RemovalArgs& args, State& s) {
  start_transmittance(args.tile, s.t);
  const std::size_t plane = plane_size(args.tile);
  for_each_quad(args.tile, [&](std::size_t pixel, int at) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto color = hn::Load(kQuad, args.tile.color + pixel + c * plane);
      const auto error = hn::Sub(color, hn::Load(kQuad, args.target + pixel + c * plane));
      hn::Store(color, kQuad, s.behind[c].v + at);
      hn::Store(hn::Add(error, error), kQuad, s.error[c].v + at);
    }
    if (args.masked)
      hn::Store(hn::Load(kQuad, args.target + pixel + 3 * plane), kQuad, s.counts.v + at);
  });
}

}  // namespace

void removal(const RemovalArgs& args) {
  const TileArgs& tile = args.tile;
  const RasterConstants& k = tile.constants;
  State state;
  load_state(args, state);

  for (std::uint32_t e = 0; e < tile.count; ++e) {
    prefetch_splat(tile, e);
    const TileEntry entry = tile.entries[e];
    const ProjectedSplat& s = tile.splats[entry.splat];
    const SplatInTile splat(s, tile);
    const Lanes color[3] = {Lanes(s.r), Lanes(s.g), Lanes(s.b)};
    Lanes change[kPacks];
    for (Lanes& part : change) part = Lanes(0.0f);
    unsigned pixels = 0;
    for (std::uint32_t blocks = entry.blocks; blocks; blocks &= blocks - 1) {
      const int block = lowest_bit(blocks);
      for (int p = 0; p < kPacks; ++p) {
        const Lanes before = state.t.load(block, p);
        const Lanes exponent = splat.exponent(splat.u_at(block, p), splat.v_at(block, p));
        const LaneMask inside = contributes(exponent, before, k);
        const Lanes alpha = zero_unless(inside, min(exp2(exponent), Lanes(k.alpha_max)));
        const Lanes weight = alpha * before, after = before - weight;
        const Lanes odds = alpha / (Lanes(1.0f) - alpha);
        const LaneMask counted =
            args.masked ? inside & (state.counts.load(block, p) > Lanes(0.0f)) : inside;
        for (int c = 0; c < 3; ++c) {
          const Lanes own = weight * color[c];
          const Lanes behind = state.behind[c].load(block, p) - own;
          state.behind[c].store(block, p, behind);
          const Lanes delta = zero_unless(counted, odds * behind - own);
          change[p] = fma(delta, delta + state.error[c].load(block, p), change[p]);
        }
        pixels += static_cast<unsigned>(__builtin_popcount(bits(counted)));
        state.t.store(block, p, after);
      }
    }
    args.costs[entry.slot] = {sum(change), static_cast<float>(pixels)};
  }
}

}  // namespace fluxgs::FLUXGS_ISA
