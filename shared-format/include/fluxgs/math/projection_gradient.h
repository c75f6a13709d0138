// The derivative of math/projection.h and math/spherical_harmonics.h: from gradients of a splat's
// footprint and colour back to its parameters. Templated on the scalar like its forward twin.
#pragma once

#include "fluxgs/math/projection.h"
#include "fluxgs/math/spherical_harmonics.h"

namespace fluxgs::math {

/// Gradient of a loss with respect to a footprint's centre (px) and covariance. `cov` is symmetric:
/// dL = xx·dΣxx + 2·xy·dΣxy + yy·dΣyy.
template <class T>
struct FootprintGradient {
  T x;            ///< of the centre
  T y;            ///< of the centre
  T cov_xx;       ///< of Σxx
  T cov_xy;       ///< of Σxy
  T cov_yy;       ///< of Σyy
  T log_opacity;  ///< of the logarithm of the opacity that is drawn: Σ h of FootprintMoments
};

/// Sums over pixels that the rasteriser accumulates for a splat, with w = (u, v) as in Footprint
/// and h = α·∂L/∂α (zero where α is limited by α_max): Σ h·w and Σ h·w·wᵀ.
template <class T>
struct FootprintMoments {
  T u;   ///< Σ h·u
  T v;   ///< Σ h·v
  T uu;  ///< Σ h·u²
  T uv;  ///< Σ h·u·v
  T vv;  ///< Σ h·v²
};

/// With q = |Λd|²: ∂q/∂centre = −2Λᵀw and ∂q/∂Σ = −(Λᵀw)(Λᵀw)ᵀ, and ∂L/∂q = −h/2.
/// `h` = Σ h.
template <class T>
FootprintGradient<T> footprint_gradient(const FootprintMoments<T>& m, const T& h, const T& xx,
                                        const T& xy, const T& yy) {
  const T half(0.5);
  return {xx * m.u,
          xy * m.u + yy * m.v,
          half * xx * xx * m.uu,
          half * xx * (xy * m.uu + yy * m.uv),
          half * (xy * xy * m.uu + T(2) * xy * yy * m.uv + yy * yy * m.vv),
          h};
}

/// ∂L/∂q for the unnormalised quaternion q, given ∂L/∂R. Zero for the zero quaternion.
template <class T>
Quat<T> quaternion_gradient(const Quat<T>& q, const Mat3<T>& dr) {
  const Quat<T> n = normalized(q);
  const T two(2);
  const Quat<T> g{two * (n.z * (dr.row1.x - dr.row0.y) + n.y * (dr.row0.z - dr.row2.x) +
                         n.x * (dr.row2.y - dr.row1.z)),
                  two * (n.y * (dr.row0.y + dr.row1.x) + n.z * (dr.row0.z + dr.row2.x) +
                         n.w * (dr.row2.y - dr.row1.z) - two * n.x * (dr.row1.y + dr.row2.z)),
                  two * (n.x * (dr.row0.y + dr.row1.x) + n.w * (dr.row0.z - dr.row2.x) +
                         n.z * (dr.row1.z + dr.row2.y) - two * n.y * (dr.row0.x + dr.row2.z)),
                  two * (n.w * (dr.row1.x - dr.row0.y) + n.x * (dr.row0.z + dr.row2.x) +
                         n.y * (dr.row1.z + dr.row2.y) - two * n.z * (dr.row0.x + dr.row1.y))};
  const T along = n.w * g.w + n.x * g.x + n.y * g.y + n.z * g.z;
  // 1/|q| = n·q/|q|², written so that tiny quaternions do not underflow.
  const T length = n.w * q.w + n.x * q.x + n.y * q.y + n.z * q.z;
  const auto zero = length <= T(0);
  const T inverse = select(zero, T(0), T(1) / select(zero, T(1), length));
  return {(g.w - n.w * along) * inverse, (g.x - n.x * along) * inverse,
          (g.y - n.y * along) * inverse, (g.z - n.z * along) * inverse};
}

/// Gradient of a loss with respect to a splat's geometry.
template <class T>
struct GeometryGradient {
  Vec3<T> position;   ///< of the centre in the world
  Vec3<T> log_scale;  ///< of the natural logarithms of the standard deviations
  Quat<T> rotation;   ///< of the unnormalised quaternion
};

/// ∂ln κ/∂axes of opacity_compensation(). With c = ax×ay, D = det Σ, D′ = det Σ′:
/// ∂ln κ/∂ax = (ay×c)·(1/D − 1/D′) − d·ax/D′, and for ay likewise with c×ax. A splat that is drawn
/// has κ ≥ α_min, so D does not vanish against D′; where it does, the derivative is 0.
template <class T>
ScreenAxes<T> compensation_gradient(const ScreenAxes<T>& axes, const T& dilation) {
  const T size2 = max(dot(axes.x, axes.x), dot(axes.y, axes.y));
  const T inverse = T(1) / sqrt(max(size2, T(1)));
  const Vec3<T> ax = axes.x * inverse, ay = axes.y * inverse;
  const T d = dilation * inverse * inverse;
  const Vec3<T> c = cross(ax, ay);
  const T det = dot(c, c), added = d * (dot(ax, ax) + dot(ay, ay)) + d * d;
  const T filtered = inverse / (det + added);
  const auto vanishes = det <= T(1e-30);
  const T along = select(vanishes, T(0), filtered * added / select(vanishes, T(1), det));
  return {cross(ay, c) * along - ax * (d * filtered), cross(c, ax) * along - ay * (d * filtered)};
}

/// Chain rule through footprint → screen axes → Jacobian, rotation, scale → position.
/// `scale` is exp(log_scale); `p` is the centre in camera space.
template <class T>
GeometryGradient<T> geometry_gradient(const FootprintGradient<T>& g, const Vec3<T>& p,
                                      const Quat<T>& q, const Vec3<T>& scale, const View<T>& view) {
  const Mat3<T>& w = view.rotation;
  const auto j = projection_jacobian(p, view);
  const Mat3<T> r = rotation_matrix(normalized(q));
  const ScreenAxes<T> axes = screen_axes(j, w, r, scale);

  // Σ = AAᵀ + dilation·I  ⇒  ∂L/∂A = 2GA
  const T two(2);
  Vec3<T> dax = (axes.x * g.cov_xx + axes.y * g.cov_xy) * two;
  Vec3<T> day = (axes.x * g.cov_xy + axes.y * g.cov_yy) * two;
  if (view.compensated) {
    const ScreenAxes<T> k = compensation_gradient(axes, view.dilation);
    dax = dax + k.x * g.log_opacity;
    day = day + k.y * g.log_opacity;
  }
  GeometryGradient<T> out;
  out.log_scale = {dax.x * axes.x.x + day.x * axes.y.x, dax.y * axes.x.y + day.y * axes.y.y,
                   dax.z * axes.x.z + day.z * axes.y.z};

  // Rows of A are diag(s)·Rᵀ·(row of J·W)
  const Vec3<T> drx{dax.x * scale.x, dax.y * scale.y, dax.z * scale.z};
  const Vec3<T> dry{day.x * scale.x, day.y * scale.y, day.z * scale.z};
  const Vec3<T> wx = w.row0 * j.x0 + w.row2 * j.x2, wy = w.row1 * j.y1 + w.row2 * j.y2;
  out.rotation = quaternion_gradient(
      q, Mat3<T>{drx * wx.x + dry * wy.x, drx * wx.y + dry * wy.y, drx * wx.z + dry * wy.z});
  const Vec3<T> dwx = r * drx, dwy = r * dry;
  const T dx0 = dot(w.row0, dwx), dx2 = dot(w.row2, dwx);
  const T dy1 = dot(w.row1, dwy), dy2 = dot(w.row2, dwy);

  // x0 = fx/z, x2 = −fx·slope/z; a slope at its limit no longer depends on the position
  const T iz = T(1) / p.z;
  const T raw_x = p.x * iz, raw_y = p.y * iz;
  const T dsx = select(raw_x == j.slope_x, -(j.x0 * dx2), T(0));
  const T dsy = select(raw_y == j.slope_y, -(j.y1 * dy2), T(0));
  const T dx = (g.x * view.fx + dsx) * iz, dy = (g.y * view.fy + dsy) * iz;
  const T dz =
      -(raw_x * dx + raw_y * dy + (j.x0 * dx0 + j.x2 * dx2 + j.y1 * dy1 + j.y2 * dy2) * iz);
  out.position = transpose_times(w, Vec3<T>{dx, dy, dz});
  return out;
}

/// ∂L/∂position through the viewing direction: `ray` = position − camera centre, `dd` =
/// ∂L/∂(ray/|ray|).
template <class T>
Vec3<T> direction_gradient(const Vec3<T>& ray, const Vec3<T>& dd) {
  const T length2 = dot(ray, ray);
  const auto zero = length2 <= T(0);
  const T inverse = select(zero, T(0), T(1) / sqrt(select(zero, T(1), length2)));
  const Vec3<T> d = ray * inverse;
  return (dd - d * dot(d, dd)) * inverse;
}

}  // namespace fluxgs::math
