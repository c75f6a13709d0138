// The derivative of forward.cpp. It replays the blending front to back: what lies behind a splat is
// the pixel's total less what has been passed, so no transmittance is ever divided back out, and
// the one quotient, by 1 − α ≥ 0.01, stays harmless.
#include "trainer/raster/cpu/kernels/kernels_isa.h"
#include "trainer/raster/cpu/kernels/tile.h"

namespace fluxgs::FLUXGS_ISA {
namespace {

/// A tile's running state.
struct State {
  TilePlane t;           // transmittance
  TilePlane behind;      // Σ over the splats still to come of αT·(c·g), and the background's part
  TilePlane gr, gg, gb;  // ∂L/∂colour
};

void load_state(const TileArgs& args, State& s) {
  start_transmittance(args, s.t);
  const std::size_t plane = plane_size(args);
  for_each_pixel_row(args, [&](std::size_t pixel, int at, int count) {
    for (int i = 0; i < count; ++i) {
      const float* c = args.color + pixel + static_cast<std::size_t>(i);
      const float* g = args.color_gradient + pixel + static_cast<std::size_t>(i);
      s.gr.v[at + i] = g[0];
      s.gg.v[at + i] = g[plane];
      s.gb.v[at + i] = g[2 * plane];
      s.behind.v[at + i] = c[0] * g[0] + c[plane] * g[plane] + c[2 * plane] * g[2 * plane];
    }
  });
}

/// Sums over the pixels of a splat–tile pair, still spread over lanes.
struct Sums {
  Lanes u{0.0f}, v{0.0f}, uu{0.0f}, uv{0.0f}, vv{0.0f}, h{0.0f}, r{0.0f}, g{0.0f}, b{0.0f};
};

void write(const Sums& s, PairGradient& out) {
  out = {sum(s.u), sum(s.v), sum(s.uu), sum(s.uv), sum(s.vv),
         sum(s.h), sum(s.r), sum(s.g),  sum(s.b),  {0, 0, 0}};
}

}  // namespace

void backward(const TileArgs& args) {
  const RasterConstants& k = args.constants;
  const LaneOffsets lanes;
  State state;
  load_state(args, state);

  std::uint32_t alive = blocks_inside(args);
  for (std::uint32_t e = 0; e < args.count; ++e) {
    const TileEntry entry = args.entries[e];
    std::uint32_t blocks = entry.blocks & alive;
    if (!blocks) {
      args.gradients[entry.slot] = {};
      continue;
    }
    const ProjectedSplat& s = args.splats[entry.splat];
    const SplatInTile in_tile(s, args, lanes);
    const Lanes log2_opacity(s.log2_opacity), cr(s.r), cg(s.g), cb(s.b);
    Sums sums;
    for (; blocks; blocks &= blocks - 1) {
      const int block = lowest_bit(blocks);
      const Lanes u_offset(in_tile.u_offset(block)), v_offset(in_tile.v_offset(block));
      bool open = false;
      for (int p = 0; p < kPacks; ++p) {
        const Lanes before = state.t.load(block, p);
        const Lanes u = in_tile.u[p] + u_offset, v = in_tile.v[p] + v_offset;
        const Alpha a = alpha_at(u, v, log2_opacity, before, k);
        const Lanes weight = zero_unless(a.contributes, a.alpha * before);
        const Lanes after = before - weight;
        const Lanes gr = state.gr.load(block, p), gg = state.gg.load(block, p),
                    gb = state.gb.load(block, p);
        const Lanes shade = fma(cr, gr, fma(cg, gg, cb * gb));  // c·g
        const Lanes behind = fnma(weight, shade, state.behind.load(block, p));
        state.t.store(block, p, after);
        state.behind.store(block, p, behind);

        // ∂L/∂α = T·(c·g) − behind/(1 − α);  h = α·∂L/∂α
        const LaneMask moves = a.contributes & (a.raw <= Lanes(k.alpha_max));
        const Lanes odds = a.alpha / (Lanes(1.0f) - a.alpha);
        const Lanes h = zero_unless(moves, fnma(behind, odds, weight * shade));
        const Lanes hu = h * u, hv = h * v;
        sums.h += h;
        sums.u += hu;
        sums.v += hv;
        sums.uu = fma(hu, u, sums.uu);
        sums.uv = fma(hu, v, sums.uv);
        sums.vv = fma(hv, v, sums.vv);
        sums.r = fma(weight, gr, sums.r);
        sums.g = fma(weight, gg, sums.g);
        sums.b = fma(weight, gb, sums.b);
        open |= any(after >= Lanes(k.transmittance_min));
      }
      if (!open) alive &= ~(1u << block);
    }
    write(sums, args.gradients[entry.slot]);
  }
}

}  // namespace fluxgs::FLUXGS_ISA
