// Projection of packs of splats: the formulas of math/ on SIMD lanes.
#include "fluxgs/math/spherical_harmonics.h"
#include "trainer/core/lanes.h"
#include "trainer/core/parameters.h"
#include "trainer/raster/cpu/kernels/kernels_isa.h"

#include <hwy/contrib/math/math-inl.h>

namespace fluxgs::FLUXGS_ISA {
namespace {

using math::Vec3;

struct Pack {
  const ProjectArgs& args;
  std::size_t i;
  Lanes operator()(int r) const {
    return Lanes::load(args.parameters + static_cast<std::size_t>(r) * args.stride + i);
  }
  Vec3<Lanes> vec3(int r) const { return {(*this)(r), (*this)(r + 1), (*this)(r + 2)}; }
};

/// Colours before they are cut off at 0.
Vec3<Lanes> shade(const Pack& pack, const Vec3<Lanes>& direction, int degree) {
  Lanes basis[15];
  math::sh_basis(degree, direction, basis);
  Lanes rgb[3];
  for (int c = 0; c < 3; ++c) {
    Lanes value = fma(Lanes(math::kSh0), pack(row::sh_dc + c), Lanes(0.5f));
    for (int k = 0; k < sh_rest_count(degree); ++k)
      value = fma(basis[k], pack(row::sh_rest + 3 * k + c), value);
    rgb[c] = value;
  }
  return {rgb[0], rgb[1], rgb[2]};
}

LaneMask lanes_below(std::size_t count) { return {hn::FirstN(kTag, count)}; }

}  // namespace

void project(const ProjectArgs& args, std::size_t begin, std::size_t end) {
  const auto view = math::convert<Lanes>(args.view);
  const RasterConstants& k = args.constants;
  for (std::size_t i = begin; i < end; i += static_cast<std::size_t>(kLanes)) {
    const Pack pack{args, i};
    const Vec3<Lanes> position = pack.vec3(row::position);
    const Vec3<Lanes> p = view.rotation * position + view.translation;
    const Lanes opacity = Lanes(1.0f) / (Lanes(1.0f) + exp(-pack(row::opacity)));
    LaneMask visible =
        (p.z > view.near_plane) & (opacity >= Lanes(k.alpha_min)) & lanes_below(end - i);
    float fields[sizeof(ProjectedSplat) / sizeof(float)][kLanes] HWY_ALIGN;
    if (any(visible)) {
      const Vec3<Lanes> s = pack.vec3(row::log_scale);
      const math::Quat<Lanes> q{pack(row::rotation), pack(row::rotation + 1),
                                pack(row::rotation + 2), pack(row::rotation + 3)};
      const auto rotation = math::rotation_matrix(math::normalized(q));
      const auto jacobian = math::projection_jacobian(p, view);
      const Vec3<Lanes> scale{exp(s.x), exp(s.y), exp(s.z)};
      const auto axes = math::screen_axes(jacobian, view.rotation, rotation, scale);
      const Lanes spread = math::depth_deviation(view.rotation.row2, rotation, scale);
      const auto f = math::footprint(axes, view.dilation);

      const Lanes inverse_z = Lanes(1.0f) / p.z;
      const Lanes x = fma(view.fx * p.x, inverse_z, view.cx);
      const Lanes y = fma(view.fy * p.y, inverse_z, view.cy);
      Lanes shown = opacity;
      if (view.compensated) {
        shown = opacity * math::opacity_compensation(axes, view.dilation);
        visible = visible & (shown >= Lanes(k.alpha_min));
      }
      const Lanes log2_opacity = hn::Log2(kTag, shown.v);
      const Lanes radius = sqrt(max(log2_opacity - Lanes(k.log2_alpha_min), Lanes(0.0f))) *
                           Lanes(1.0f / kFactorScale);
      const Lanes half_width = radius * f.deviation_x, half_height = radius * f.deviation_y;
      const Lanes half(0.5f);
      visible = visible & (spread <= view.depth_spread_max * p.z) & (x + half_width >= half) &
                (x - half_width <= view.width - half) & (y + half_height >= half) &
                (y - half_height <= view.height - half);

      const Vec3<Lanes> ray = position - view.center;
      const Lanes length2 = dot(ray, ray);
      const Lanes inverse_length = Lanes(1.0f) / sqrt(max(length2, Lanes(1e-30f)));
      const Vec3<Lanes> raw = shade(pack, ray * inverse_length, args.sh_degree);
      const Lanes zero(0.0f);
      const Vec3<Lanes> color{max(raw.x, zero), max(raw.y, zero), max(raw.z, zero)};
      const Lanes factor_scale(kFactorScale);
      const Lanes columns[] = {x,
                               y,
                               f.xx * factor_scale,
                               f.xy * factor_scale,
                               f.yy * factor_scale,
                               log2_opacity,
                               color.x,
                               color.y,
                               color.z,
                               p.z,
                               half_width,
                               half_height,
                               opacity};
      // What max() and the exponentials limit is asked before they do
      Lanes total =
          pack(row::opacity) + s.x + s.y + s.z + q.w + q.x + q.y + q.z + raw.x + raw.y + raw.z;
      for (std::size_t c = 0; c < 13; ++c) {
        columns[c].store(fields[c]);
        total += columns[c];
      }
      visible = visible & (total - total == zero);  // all finite
    }
    const unsigned mask = bits(visible);
    for (int lane = 0; lane < kLanes; ++lane) {
      const std::size_t at = i + static_cast<std::size_t>(lane);
      args.visible[at] = (mask >> lane) & 1u;
      if (!((mask >> lane) & 1u)) continue;
      float* out = &args.out[at].x;
      for (int c = 0; c < 13; ++c) out[c] = fields[c][lane];
    }
  }
}

}  // namespace fluxgs::FLUXGS_ISA
