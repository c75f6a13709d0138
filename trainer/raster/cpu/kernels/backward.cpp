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
  for_each_quad(args, [&](std::size_t pixel, int at) {
    const float* c = args.color + pixel;
    const float* g = args.color_gradient + pixel;
    const auto red = hn::Load(kQuad, g), green = hn::Load(kQuad, g + plane),
               blue = hn::Load(kQuad, g + 2 * plane);
    hn::Store(red, kQuad, s.gr.v + at);
    hn::Store(green, kQuad, s.gg.v + at);
    hn::Store(blue, kQuad, s.gb.v + at);
    auto total = hn::Mul(hn::Load(kQuad, c), red);
    total = hn::MulAdd(hn::Load(kQuad, c + plane), green, total);
    total = hn::MulAdd(hn::Load(kQuad, c + 2 * plane), blue, total);
    if (args.transmittance_gradient) {
      const auto left = hn::Load(kQuad, args.transmittance + pixel);
      total = hn::MulAdd(left, hn::Load(kQuad, args.transmittance_gradient + pixel), total);
    }
    hn::Store(total, kQuad, s.behind.v + at);
  });
}

/// Sums over the pixels of a splat–tile pair that lie in a pack of their blocks.
struct Sums {
  Lanes u{0.0f}, v{0.0f}, uu{0.0f}, uv{0.0f}, vv{0.0f}, h{0.0f}, r{0.0f}, g{0.0f}, b{0.0f};
};

/// One of the sums over all packs, in four parts.
hn::Vec<Quad> quad_of(const Sums (&sums)[kPacks], Lanes Sums::* member) {
  Lanes packs[kPacks];
  for (int p = 0; p < kPacks; ++p) packs[p] = sums[p].*member;
  return quad_sum(packs);
}

void write(const Sums (&s)[kPacks], PairGradient& out) {
  const auto pair = [](hn::Vec<Quad> x, hn::Vec<Quad> y) {
    return hn::Add(hn::InterleaveLower(kQuad, x, y), hn::InterleaveUpper(kQuad, x, y));
  };
  const auto four = [&](hn::Vec<Quad> a, hn::Vec<Quad> b, hn::Vec<Quad> c, hn::Vec<Quad> d) {
    return pair(pair(a, c), pair(b, d));
  };
  const auto of = [&](Lanes Sums::* member) { return quad_of(s, member); };
  const auto zero = hn::Zero(kQuad);
  hn::Store(four(of(&Sums::u), of(&Sums::v), of(&Sums::uu), of(&Sums::uv)), kQuad, &out.u);
  hn::Store(four(of(&Sums::vv), of(&Sums::h), of(&Sums::r), of(&Sums::g)), kQuad, &out.vv);
  hn::Store(four(of(&Sums::b), zero, zero, zero), kQuad, &out.b);
}

/// Passes a splat over blocks and adds to its sums. Inline, so that the sums stay in registers.
/// kLimited: α may have to be limited.
template <bool kLimited>
HWY_INLINE void replay(const ProjectedSplat& s, std::uint32_t blocks, const TileArgs& args,
                       State& state, Sums (&sums)[kPacks]) {
  const RasterConstants& k = args.constants;
  const SplatInTile splat(s, args);
  const Lanes cr(s.r), cg(s.g), cb(s.b);
  for (; blocks; blocks &= blocks - 1) {
    const int block = lowest_bit(blocks);
    for (int p = 0; p < kPacks; ++p) {
      const Lanes before = state.t.load(block, p);
      const Lanes u = splat.u_at(block, p), v = splat.v_at(block, p);
      const Lanes exponent = splat.exponent(u, v);
      const LaneMask inside = contributes(exponent, before, k);
      const Lanes raw = exp2(exponent);
      const Lanes alpha = kLimited ? min(raw, Lanes(k.alpha_max)) : raw;
      const Lanes weight = zero_unless(inside, alpha * before);
      const Lanes after = before - weight;
      const Lanes gr = state.gr.load(block, p), gg = state.gg.load(block, p),
                  gb = state.gb.load(block, p);
      const Lanes passed = weight * fma(cr, gr, fma(cg, gg, cb * gb));  // αT·(c·g)
      const Lanes behind = state.behind.load(block, p) - passed;
      state.t.store(block, p, after);
      state.behind.store(block, p, behind);

      // ∂L/∂α = T·(c·g) − behind/(1 − α);  h = α·∂L/∂α
      const LaneMask moves = kLimited ? inside & (raw <= Lanes(k.alpha_max)) : inside;
      const Lanes odds = alpha / (Lanes(1.0f) - alpha);
      const Lanes h = zero_unless(moves, fnma(behind, odds, passed));
      const Lanes hu = h * u, hv = h * v;
      sums[p].h += h;
      sums[p].u += hu;
      sums[p].v += hv;
      sums[p].uu = fma(hu, u, sums[p].uu);
      sums[p].uv = fma(hu, v, sums[p].uv);
      sums[p].vv = fma(hv, v, sums[p].vv);
      sums[p].r = fma(weight, gr, sums[p].r);
      sums[p].g = fma(weight, gg, sums[p].g);
      sums[p].b = fma(weight, gb, sums[p].b);
    }
  }
}

}  // namespace

void backward(const TileArgs& args) {
  State state;
  load_state(args, state);

  for (std::uint32_t e = 0; e < args.count; ++e) {
    prefetch_splat(args, e);
    const TileEntry entry = args.entries[e];
    if (!entry.blocks) {
      args.gradients[entry.slot] = {};
      continue;
    }
    const ProjectedSplat& s = args.splats[entry.splat];
    Sums sums[kPacks];
    if (may_exceed_limit(s, args.constants))
      replay<true>(s, entry.blocks, args, state, sums);
    else
      replay<false>(s, entry.blocks, args, state, sums);
    write(sums, args.gradients[entry.slot]);
  }
}

}  // namespace fluxgs::FLUXGS_ISA
