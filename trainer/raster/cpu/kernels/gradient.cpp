// From summed pair gradients to parameter gradients, a pack of splats at a time.
#include "fluxgs/math/projection_gradient.h"
#include "trainer/core/lanes.h"
#include "trainer/core/parameters.h"
#include "trainer/raster/cpu/kernels/kernels_isa.h"

namespace fluxgs::FLUXGS_ISA {
namespace {

using math::Vec3;

/// The stored factor Λ′ is k·Λ and the moments are of w′ = k·w, k = kFactorScale: Λᵀw needs 1/k²,
/// Λᵀwwᵀ Λ needs 1/k⁴.
constexpr float kFirst = 1.0f / (kFactorScale * kFactorScale);
constexpr float kSecond = kFirst * kFirst;

/// Floats from what is read to what is asked for: a pack's rows lie in some 120 pages, more than
/// the processor follows by itself.
constexpr std::size_t kAhead = 16;

struct Rows {
  const float* base;
  std::size_t stride, i;
  Lanes operator()(int r) const {
    const float* at = base + static_cast<std::size_t>(r) * stride + i;
    __builtin_prefetch(at + kAhead);
    return Lanes::load(at);
  }
  Vec3<Lanes> vec3(int r) const { return {(*this)(r), (*this)(r + 1), (*this)(r + 2)}; }
};

/// Stores rows of gradients and remembers whether every lane stayed finite.
struct Out {
  float* base;
  std::size_t stride, i;
  LaneMask visible;
  Lanes total{0.0f};
  void operator()(int r, Lanes x) {
    const Lanes kept = zero_unless(visible, x);
    float* at = base + static_cast<std::size_t>(r) * stride + i;
    __builtin_prefetch(at + kAhead, 1);
    kept.store(at);
    total += kept;
  }
  void vec3(int r, const Vec3<Lanes>& x) {
    (*this)(r, x.x);
    (*this)(r + 1, x.y);
    (*this)(r + 2, x.z);
  }
};

/// Writes the gradients of the SH coefficients and returns ∂L/∂direction.
Vec3<Lanes> shade_gradient(const Rows& parameters, const Vec3<Lanes>& direction, int degree,
                           const Vec3<Lanes>& color_gradient, Out& out) {
  Lanes basis[15];
  Vec3<Lanes> slopes[15];
  math::sh_basis(degree, direction, basis);
  math::sh_basis_gradient(degree, direction, slopes);
  out.vec3(row::sh_dc, color_gradient * Lanes(math::kSh0));
  Vec3<Lanes> d{Lanes(0.0f), Lanes(0.0f), Lanes(0.0f)};
  for (int k = 0; k < sh_rest_count(degree); ++k) {
    out.vec3(row::sh_rest + 3 * k, color_gradient * basis[k]);
    const Lanes along = dot(color_gradient, parameters.vec3(row::sh_rest + 3 * k));
    d = d + slopes[k] * along;
  }
  return d;
}

/// The structs of a pack of splats. Lanes beyond the last splat get its fields; lanes that are not
/// visible may get anything, which Out drops.
template <class T>
struct Fields {
  const T* first;
  hn::Vec<TagI> lanes;
  Fields(const T* items, std::size_t i, std::size_t size)
      : first(items + i),
        lanes(hn::Min(hn::Iota(kTagI, 0), hn::Set(kTagI, static_cast<int>(size - 1 - i)))) {}
  Lanes operator()(float T::* member) const {
    constexpr int kFloats = sizeof(T) / sizeof(float);
    return hn::GatherIndex(kTag, &(first->*member), hn::Mul(lanes, hn::Set(kTagI, kFloats)));
  }
};

unsigned gradient_pack(const GradientArgs& args, const math::View<Lanes>& view, std::size_t i,
                       LaneMask visible) {
  const unsigned mask = bits(visible);
  const Rows parameters{args.parameters, args.stride, i};
  const Fields splats(args.splats, i, args.size);
  const Fields sums(args.sums, i, args.size);
  using Sum = PairGradient;
  using Splat = ProjectedSplat;
  Out out{args.gradients, args.stride, i, visible};

  const Lanes first(kFirst), second(kSecond);
  const math::FootprintMoments<Lanes> moments{sums(&Sum::u) * first, sums(&Sum::v) * first,
                                              sums(&Sum::uu) * second, sums(&Sum::uv) * second,
                                              sums(&Sum::vv) * second};
  const Lanes h = sums(&Sum::h);
  const auto footprint = math::footprint_gradient(moments, h, splats(&Splat::xx),
                                                  splats(&Splat::xy), splats(&Splat::yy));
  const Vec3<Lanes> position = parameters.vec3(row::position);
  const Vec3<Lanes> p = view.rotation * position + view.translation;
  const Vec3<Lanes> s = parameters.vec3(row::log_scale);
  const math::Quat<Lanes> q{parameters(row::rotation), parameters(row::rotation + 1),
                            parameters(row::rotation + 2), parameters(row::rotation + 3)};
  const auto g =
      math::geometry_gradient(footprint, p, q, Vec3<Lanes>{exp(s.x), exp(s.y), exp(s.z)}, view);

  // A colour cut off at 0 does not move
  const auto open = [&](float Splat::* value, float Sum::* sum) {
    return zero_unless(splats(value) > Lanes(0.0f), sums(sum));
  };
  const Vec3<Lanes> color{open(&Splat::r, &Sum::r), open(&Splat::g, &Sum::g),
                          open(&Splat::b, &Sum::b)};
  const Vec3<Lanes> ray = position - view.center;
  const Lanes inverse_length = Lanes(1.0f) / sqrt(max(dot(ray, ray), Lanes(1e-30f)));
  const Vec3<Lanes> d =
      shade_gradient(parameters, ray * inverse_length, args.sh_degree, color, out);

  out.vec3(row::position, g.position + math::direction_gradient(ray, d));
  out.vec3(row::log_scale, g.log_scale);
  out(row::rotation, g.rotation.w);
  out(row::rotation + 1, g.rotation.x);
  out(row::rotation + 2, g.rotation.y);
  out(row::rotation + 3, g.rotation.z);
  out(row::opacity, h * (Lanes(1.0f) - splats(&Splat::opacity)));

  // The densification threshold of 3DGS is in normalised device coordinates: px × half the size
  const Lanes nx = footprint.x * view.width * Lanes(0.5f),
              ny = footprint.y * view.height * Lanes(0.5f);
  zero_unless(out.visible, sqrt(nx * nx + ny * ny)).store(args.center_gradient + i);
  return mask & ~bits(out.total - out.total == Lanes(0.0f));
}

}  // namespace

std::uint32_t gradient(const GradientArgs& args, std::size_t begin, std::size_t end) {
  const auto view = math::convert<Lanes>(args.view);
  std::uint32_t rejected = 0;
  for (std::size_t i = begin; i < end; i += static_cast<std::size_t>(kLanes)) {
    const LaneMask visible = nonzero(args.visible + i);
    if (!any(visible)) continue;
    const unsigned bad = gradient_pack(args, view, i, visible);
    for (int lane = 0; lane < kLanes; ++lane)
      if ((bad >> lane) & 1u) args.visible[i + static_cast<std::size_t>(lane)] = 0, ++rejected;
  }
  return rejected;
}

}  // namespace fluxgs::FLUXGS_ISA
