// A pack of float lanes with operators, over Highway, so that the templated formulas of math/ run
// on as many splats at a time as the instruction set holds. Only kernels include this: it belongs
// to the namespace of the instruction set it is compiled for.
#pragma once

#include <hwy/highway.h>

#include "fluxgs/math/scalar.h"

namespace fluxgs::FLUXGS_ISA {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, 16>;
using TagI = hn::RebindToSigned<Tag>;
inline constexpr Tag kTag{};
inline constexpr TagI kTagI{};
inline constexpr int kLanes = static_cast<int>(hn::MaxLanes(Tag()));
static_assert(kLanes == FLUXGS_LANES,
              "the compiler's flags do not give the lanes this set should have");

struct LaneMask {
  hn::Mask<Tag> m;
  friend LaneMask operator&(LaneMask a, LaneMask b) { return {hn::And(a.m, b.m)}; }
  friend LaneMask operator|(LaneMask a, LaneMask b) { return {hn::Or(a.m, b.m)}; }
};

struct Lanes {
  hn::Vec<Tag> v;

  Lanes() = default;
  Lanes(hn::Vec<Tag> vector) : v(vector) {}
  explicit Lanes(float value) : v(hn::Set(kTag, value)) {}
  explicit Lanes(double value) : Lanes(static_cast<float>(value)) {}
  explicit Lanes(int value) : Lanes(static_cast<float>(value)) {}

  static Lanes load(const float* aligned) { return hn::Load(kTag, aligned); }
  static Lanes load_unaligned(const float* p) { return hn::LoadU(kTag, p); }
  void store(float* aligned) const { hn::Store(v, kTag, aligned); }
  void store_unaligned(float* p) const { hn::StoreU(v, kTag, p); }

  friend Lanes operator+(Lanes a, Lanes b) { return hn::Add(a.v, b.v); }
  friend Lanes operator-(Lanes a, Lanes b) { return hn::Sub(a.v, b.v); }
  friend Lanes operator*(Lanes a, Lanes b) { return hn::Mul(a.v, b.v); }
  friend Lanes operator/(Lanes a, Lanes b) { return hn::Div(a.v, b.v); }
  friend Lanes operator-(Lanes a) { return hn::Neg(a.v); }
  Lanes& operator+=(Lanes b) { return *this = *this + b; }

  friend LaneMask operator<(Lanes a, Lanes b) { return {hn::Lt(a.v, b.v)}; }
  friend LaneMask operator<=(Lanes a, Lanes b) { return {hn::Le(a.v, b.v)}; }
  friend LaneMask operator>(Lanes a, Lanes b) { return {hn::Gt(a.v, b.v)}; }
  friend LaneMask operator>=(Lanes a, Lanes b) { return {hn::Ge(a.v, b.v)}; }
  friend LaneMask operator==(Lanes a, Lanes b) { return {hn::Eq(a.v, b.v)}; }

  friend Lanes select(LaneMask m, Lanes yes, Lanes no) { return hn::IfThenElse(m.m, yes.v, no.v); }
  friend Lanes max(Lanes a, Lanes b) { return hn::Max(a.v, b.v); }
  friend Lanes min(Lanes a, Lanes b) { return hn::Min(a.v, b.v); }
  friend Lanes abs(Lanes a) { return hn::Abs(a.v); }
  friend Lanes sqrt(Lanes a) { return hn::Sqrt(a.v); }
};

/// a·b + c and c − a·b, rounded once where the hardware can.
inline Lanes fma(Lanes a, Lanes b, Lanes c) { return hn::MulAdd(a.v, b.v, c.v); }
inline Lanes fnma(Lanes a, Lanes b, Lanes c) { return hn::NegMulAdd(a.v, b.v, c.v); }

/// x, or 0 where the mask is off; NaN and infinity in those lanes do not matter.
inline Lanes zero_unless(LaneMask m, Lanes x) { return hn::IfThenElseZero(m.m, x.v); }

/// Bit i tells lane i.
inline unsigned bits(LaneMask m) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(kTag, m.m, bytes);
  return bytes[0] | static_cast<unsigned>(bytes[1]) << 8;
}
/// Lanes whose byte is not zero.
inline LaneMask nonzero(const std::uint8_t* bytes) {
  const hn::Rebind<std::uint8_t, Tag> bytes_tag;
  const auto wide = hn::PromoteTo(kTagI, hn::LoadU(bytes_tag, bytes));
  return {hn::RebindMask(kTag, hn::Ne(wide, hn::Zero(kTagI)))};
}
inline bool all(LaneMask m) { return hn::AllTrue(kTag, m.m); }
inline bool any(LaneMask m) { return !hn::AllFalse(kTag, m.m); }
/// Every four lanes become their least, their greatest.
inline Lanes quad_min(Lanes a) {
  const Lanes pairs = hn::Min(a.v, hn::Shuffle2301(a.v));
  return hn::Min(pairs.v, hn::Shuffle1032(pairs.v));
}
inline Lanes quad_max(Lanes a) {
  const Lanes pairs = hn::Max(a.v, hn::Shuffle2301(a.v));
  return hn::Max(pairs.v, hn::Shuffle1032(pairs.v));
}
/// Packs that hold sixteen floats. What is summed over many values is summed in sixteen parts by
/// every instruction set, so that those with fused products give the same bits.
inline constexpr int kPacks = 16 / kLanes;

/// Lanes i, i + 4, i + 8, … of a vector added up, halves first.
template <class D>
inline hn::Vec<hn::Full128<float>> quad_sum(D d, hn::Vec<D> v) {
  if constexpr (hn::MaxLanes(d) == 4) {
    return v;
  } else {
    const hn::Half<D> half;
    return quad_sum(half, hn::Add(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  }
}
/// The same over sixteen parts.
inline hn::Vec<hn::Full128<float>> quad_sum(const Lanes (&packs)[kPacks]) {
  Lanes sums[kPacks];
  for (int p = 0; p < kPacks; ++p) sums[p] = packs[p];
  for (int n = kPacks / 2; n > 0; n /= 2)
    for (int p = 0; p < n; ++p) sums[p] += sums[p + n];
  return quad_sum(kTag, sums[0].v);
}
/// The sum of sixteen parts.
inline float sum(const Lanes (&packs)[kPacks]) {
  alignas(16) float q[4];
  hn::Store(quad_sum(packs), hn::Full128<float>(), q);
  return (q[0] + q[2]) + (q[1] + q[3]);
}

/// 2^x for x in [−126, 127], relative error < 1.5e-7: round to the nearest integer by adding
/// 1.5·2²³, a minimax polynomial of degree 5 on the rest, then add the integer to the exponent.
inline Lanes exp2(Lanes x) {
  const Lanes magic(12582912.0f);
  const Lanes shifted = x + magic;
  const Lanes f = x - (shifted - magic);
  Lanes p = fma(f, Lanes(0.0013276472454890609f), Lanes(0.009675541892647743f));
  p = fma(p, f, Lanes(0.05550713092088699f));
  p = fma(p, f, Lanes(0.24022120237350464f));
  p = fma(p, f, Lanes(0.6931469440460205f));
  p = fma(p, f, Lanes(1.0000001192092896f));
  const auto exponent = hn::ShiftLeft<23>(hn::BitCast(kTagI, shifted.v));
  return Lanes(hn::BitCast(kTag, hn::Add(hn::BitCast(kTagI, p.v), exponent)));
}

/// e^x, limited to the range of normal floats.
inline Lanes exp(Lanes x) {
  const Lanes limited = min(max(x, Lanes(-87.0f)), Lanes(88.0f));
  // In two parts, so that x·log2(e) keeps its fraction for large x
  const Lanes rounded = hn::Round((limited * Lanes(1.4426950408889634)).v);
  const Lanes rest =
      fnma(rounded, Lanes(-2.12194440e-4f), fnma(rounded, Lanes(0.693359375f), limited));
  const Lanes f = exp2(rest * Lanes(1.4426950408889634));
  const auto exponent = hn::ShiftLeft<23>(hn::ConvertTo(kTagI, rounded.v));
  return Lanes(hn::BitCast(kTag, hn::Add(hn::BitCast(kTagI, f.v), exponent)));
}

}  // namespace fluxgs::FLUXGS_ISA
