// Front-to-back blending of one tile. The tile's state stays in the first-level cache; a splat
// touches only the 4×4 blocks that its ellipse reaches and that are not yet opaque.
#include "trainer/raster/cpu/kernels/kernels_isa.h"
#include "trainer/raster/cpu/kernels/tile.h"

namespace fluxgs::FLUXGS_ISA {

std::uint32_t forward(const TileArgs& args) {
  const RasterConstants& k = args.constants;
  const LaneOffsets lanes;
  TilePlane t, r, g, b;
  start_transmittance(args, t);

  std::uint32_t alive = blocks_inside(args);
  std::uint64_t pairs = 0;
  std::uint32_t used = 0;
  for (; used < args.count && alive; ++used) {
    const TileEntry entry = args.entries[used];
    std::uint32_t blocks = entry.blocks & alive;
    if (!blocks) continue;
    const ProjectedSplat& s = args.splats[entry.splat];
    const SplatInTile in_tile(s, args, lanes);
    const Lanes log2_opacity(s.log2_opacity), cr(s.r), cg(s.g), cb(s.b);
    for (; blocks; blocks &= blocks - 1) {
      const int block = lowest_bit(blocks);
      const Lanes u_offset(in_tile.u_offset(block)), v_offset(in_tile.v_offset(block));
      bool open = false;
      for (int p = 0; p < kPacks; ++p) {
        const Lanes before = t.load(block, p);
        const Alpha a =
            alpha_at(in_tile.u[p] + u_offset, in_tile.v[p] + v_offset, log2_opacity, before, k);
        const Lanes weight = zero_unless(a.contributes, a.alpha * before);
        const Lanes after = before - weight;
        r.store(block, p, fma(cr, weight, r.load(block, p)));
        g.store(block, p, fma(cg, weight, g.load(block, p)));
        b.store(block, p, fma(cb, weight, b.load(block, p)));
        t.store(block, p, after);
        open |= any(after >= Lanes(k.transmittance_min));
        if (args.pairs) pairs += static_cast<unsigned>(__builtin_popcount(bits(a.contributes)));
      }
      if (!open) alive &= ~(1u << block);
    }
  }

  const std::size_t plane = plane_size(args);
  for_each_pixel_row(args, [&](std::size_t pixel, int at, int count) {
    for (int i = 0; i < count; ++i) {
      float* out = args.color + pixel + static_cast<std::size_t>(i);
      const float rest = t.v[at + i];
      out[0] = r.v[at + i] + rest * k.background[0];
      out[plane] = g.v[at + i] + rest * k.background[1];
      out[2 * plane] = b.v[at + i] + rest * k.background[2];
    }
  });
  if (args.pairs) *args.pairs += pairs;
  return used;
}

}  // namespace fluxgs::FLUXGS_ISA
