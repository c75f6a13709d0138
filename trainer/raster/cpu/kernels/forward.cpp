// Front-to-back blending of one tile. The tile's state stays in the first-level cache; a splat
// touches only the 4×4 blocks that its ellipse reaches and that are not yet opaque.
#include "trainer/raster/cpu/kernels/kernels_isa.h"
#include "trainer/raster/cpu/kernels/tile.h"

namespace fluxgs::FLUXGS_ISA {

namespace {

/// A tile's running state.
struct State {
  TilePlane t, r, g, b;
};

void store_image(const TileArgs& args, const State& s) {
  const auto background = [&](int c) { return hn::Set(kQuad, args.constants.background[c]); };
  const auto red = background(0), green = background(1), blue = background(2);
  const std::size_t plane = plane_size(args);
  for_each_quad(args, [&](std::size_t pixel, int at) {
    const auto rest = hn::Load(kQuad, s.t.v + at);
    hn::Store(rest, kQuad, args.transmittance + pixel);
    float* out = args.color + pixel;
    hn::Store(hn::MulAdd(rest, red, hn::Load(kQuad, s.r.v + at)), kQuad, out);
    hn::Store(hn::MulAdd(rest, green, hn::Load(kQuad, s.g.v + at)), kQuad, out + plane);
    hn::Store(hn::MulAdd(rest, blue, hn::Load(kQuad, s.b.v + at)), kQuad, out + 2 * plane);
  });
}

}  // namespace

std::uint32_t forward(const TileArgs& args) {
  const RasterConstants& k = args.constants;
  State state;
  start_transmittance(args, state.t);

  std::uint32_t alive = blocks_inside(args);
  std::uint64_t pairs = 0;
  std::uint32_t used = 0;
  for (; used < args.count && alive; ++used) {
    prefetch_splat(args, used);
    const TileEntry entry = args.entries[used];
    std::uint32_t blocks = entry.blocks & alive;
    args.entries[used].blocks = blocks;
    if (!blocks) continue;
    const ProjectedSplat& s = args.splats[entry.splat];
    const SplatInTile splat(s, args);
    const Lanes cr(s.r), cg(s.g), cb(s.b);
    for (; blocks; blocks &= blocks - 1) {
      const int block = lowest_bit(blocks);
      bool open = false;
      for (int p = 0; p < kPacks; ++p) {
        const Lanes before = state.t.load(block, p);
        const Lanes exponent = splat.exponent(splat.u_at(block, p), splat.v_at(block, p));
        const LaneMask inside = contributes(exponent, before, k);
        const Lanes alpha = min(exp2(exponent), Lanes(k.alpha_max));
        const Lanes weight = zero_unless(inside, alpha * before);
        const Lanes after = before - weight;
        state.r.store(block, p, fma(cr, weight, state.r.load(block, p)));
        state.g.store(block, p, fma(cg, weight, state.g.load(block, p)));
        state.b.store(block, p, fma(cb, weight, state.b.load(block, p)));
        state.t.store(block, p, after);
        open |= any(after >= Lanes(k.transmittance_min));
        if (args.pairs) pairs += static_cast<unsigned>(__builtin_popcount(bits(inside)));
      }
      if (!open) alive &= ~(1u << block);
    }
  }
  store_image(args, state);
  if (args.pairs) *args.pairs += pairs;
  return used;
}

}  // namespace fluxgs::FLUXGS_ISA
