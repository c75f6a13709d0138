// Projection of a 3D Gaussian to its footprint on the image (EWA splatting: Zwicker et al. 2001;
// 3DGS: Kerbl et al. 2023, section 4), in forms that stay accurate in single precision.
#pragma once

#include "fluxgs/camera.h"
#include "fluxgs/math/scalar.h"
#include "fluxgs/math/vec.h"
#include "fluxgs/render_options.h"

namespace fluxgs::math {

/// A Camera with the derived values that projection needs, in the scalar type of the formulas.
template <class T>
struct View {
  Mat3<T> rotation;     ///< world → camera
  Vec3<T> translation;  ///< as Camera::translation
  Vec3<T> center;       ///< of projection, in the world
  T fx;                 ///< focal length, px
  T fy;                 ///< focal length, px
  T cx;                 ///< principal point, px
  T cy;                 ///< principal point, px
  T width;              ///< px
  T height;             ///< px
  T slope_x_min;        ///< least x/z in the Jacobian
  T slope_x_max;        ///< largest x/z in the Jacobian
  T slope_y_min;        ///< least y/z in the Jacobian
  T slope_y_max;        ///< largest y/z in the Jacobian
  T dilation;           ///< of the ScreenFilter, px²
  T near_plane;         ///< of RenderOptions, scene units
  T depth_spread_max;   ///< > 0: of RenderOptions, a large value for no limit
  bool compensated;     ///< of the ScreenFilter
};

/// The view of a camera with these options; without a filter among them it is the classic one.
template <class T>
View<T> make_view(const Camera& camera, const RenderOptions& options) {
  const auto scalar = [](double v) { return T(v); };
  const auto vec = [&](const glm::dvec3& v) {
    return Vec3<T>{scalar(v.x), scalar(v.y), scalar(v.z)};
  };
  const ScreenFilter filter = options.filter.value_or(ScreenFilter{});
  const glm::dmat3 rows =
      glm::transpose(camera.rotation);  // columns of the transpose are rows of R
  const double mx = options.frustum_margin * camera.width,
               my = options.frustum_margin * camera.height;
  return {{vec(rows[0]), vec(rows[1]), vec(rows[2])},
          vec(camera.translation),
          vec(camera.center()),
          scalar(camera.fx),
          scalar(camera.fy),
          scalar(camera.cx),
          scalar(camera.cy),
          scalar(camera.width),
          scalar(camera.height),
          scalar((-mx - camera.cx) / camera.fx),
          scalar((camera.width + mx - camera.cx) / camera.fx),
          scalar((-my - camera.cy) / camera.fy),
          scalar((camera.height + my - camera.cy) / camera.fy),
          scalar(filter.dilation),
          scalar(options.near_plane),
          scalar(options.depth_spread_max > 0 ? options.depth_spread_max : 1e30),
          filter.compensated};
}

/// The same view in another scalar type, e.g. one value to all lanes of a pack.
template <class To, class From>
View<To> convert(const View<From>& v) {
  const auto vec = [](const Vec3<From>& a) { return Vec3<To>{To(a.x), To(a.y), To(a.z)}; };
  return {{vec(v.rotation.row0), vec(v.rotation.row1), vec(v.rotation.row2)},
          vec(v.translation),
          vec(v.center),
          To(v.fx),
          To(v.fy),
          To(v.cx),
          To(v.cy),
          To(v.width),
          To(v.height),
          To(v.slope_x_min),
          To(v.slope_x_max),
          To(v.slope_y_min),
          To(v.slope_y_max),
          To(v.dilation),
          To(v.near_plane),
          To(v.depth_spread_max),
          v.compensated};
}

/// q/|q|. Scaled by the largest component first, so that tiny quaternions do not underflow;
/// the zero quaternion becomes the identity.
template <class T>
Quat<T> normalized(const Quat<T>& q) {
  const T largest = max(max(abs(q.w), abs(q.x)), max(abs(q.y), abs(q.z)));
  const auto zero = largest <= T(0);
  const T scale = T(1) / select(zero, T(1), largest);
  const Quat<T> s{select(zero, T(1), q.w * scale), q.x * scale, q.y * scale, q.z * scale};
  const T inverse = T(1) / sqrt(s.w * s.w + s.x * s.x + s.y * s.y + s.z * s.z);
  return {s.w * inverse, s.x * inverse, s.y * inverse, s.z * inverse};
}

/// The rotation matrix of a unit quaternion.
template <class T>
Mat3<T> rotation_matrix(const Quat<T>& q) {
  const T two(2), one(1);
  return {{one - two * (q.y * q.y + q.z * q.z), two * (q.x * q.y - q.w * q.z),
           two * (q.x * q.z + q.w * q.y)},
          {two * (q.x * q.y + q.w * q.z), one - two * (q.x * q.x + q.z * q.z),
           two * (q.y * q.z - q.w * q.x)},
          {two * (q.x * q.z - q.w * q.y), two * (q.y * q.z + q.w * q.x),
           one - two * (q.x * q.x + q.y * q.y)}};
}

/// The projection's Jacobian at a point p of camera space, as rows (jx0, 0, jx2), (0, jy1, jy2).
/// The slopes are limited: beyond the image's margin the linearisation blows up (3DGS: 1.3).
template <class T>
struct Jacobian {
  T x0;       ///< jx0
  T x2;       ///< jx2
  T y1;       ///< jy1
  T y2;       ///< jy2
  T slope_x;  ///< the limited x/z
  T slope_y;  ///< the limited y/z
};

/// The Jacobian at `p` of camera space, p.z > 0.
template <class T>
Jacobian<T> projection_jacobian(const Vec3<T>& p, const View<T>& view) {
  const T inverse_z = T(1) / p.z;
  const T sx = min(max(p.x * inverse_z, view.slope_x_min), view.slope_x_max);
  const T sy = min(max(p.y * inverse_z, view.slope_y_min), view.slope_y_max);
  const T x0 = view.fx * inverse_z, y1 = view.fy * inverse_z;
  return {x0, -(x0 * sx), y1, -(y1 * sy), sx, sy};
}

/// The Gaussian's standard deviation along the view direction, scene units, for
/// RenderOptions::depth_spread_max.
template <class T>
T depth_deviation(const Vec3<T>& forward, const Mat3<T>& rotation, const Vec3<T>& scale) {
  const Vec3<T> f = transpose_times(rotation, forward);
  const Vec3<T> axes{f.x * scale.x, f.y * scale.y, f.z * scale.z};
  return sqrt(dot(axes, axes));
}

/// A 2×3 matrix: the images on the screen (px) of the Gaussian's three principal axes,
/// J·W·R·diag(s). The projected covariance is axes·axesᵀ + dilation·I.
template <class T>
struct ScreenAxes {
  Vec3<T> x;  ///< first row, px
  Vec3<T> y;  ///< second row, px
};

/// J·W·R·diag(s); `scale` are the standard deviations, scene units.
template <class T>
ScreenAxes<T> screen_axes(const Jacobian<T>& j, const Mat3<T>& world_to_camera,
                          const Mat3<T>& rotation, const Vec3<T>& scale) {
  const Vec3<T> wx = world_to_camera.row0 * j.x0 + world_to_camera.row2 * j.x2;
  const Vec3<T> wy = world_to_camera.row1 * j.y1 + world_to_camera.row2 * j.y2;
  const Vec3<T> rx = transpose_times(rotation, wx), ry = transpose_times(rotation, wy);
  return {{rx.x * scale.x, rx.y * scale.y, rx.z * scale.z},
          {ry.x * scale.x, ry.y * scale.y, ry.z * scale.z}};
}

/// The footprint's quadratic form as a triangular factor: with d = (pixel − centre),
///   u = xx·d.x + xy·d.y,  v = yy·d.y,  α = opacity·exp(−½(u² + v²)).
/// This is the Cholesky factor of the inverse covariance (conic = ΛᵀΛ). Evaluating u² + v² keeps
/// its accuracy on needles, where a·dx² + 2b·dx·dy + c·dy² cancels.
template <class T>
struct Footprint {
  T xx;           ///< 1/px
  T xy;           ///< 1/px
  T yy;           ///< 1/px
  T deviation_x;  ///< px, √ of the covariance's diagonal: half-extent of u²+v² ≤ 1
  T deviation_y;  ///< px, likewise
};

/// The determinant is taken as |ax×ay|² + dilation·trace + dilation², never as ad − b², and in
/// units of the larger axis, so that neither needles nor splats of 1e10 px lose it.
template <class T>
Footprint<T> footprint(const ScreenAxes<T>& axes, const T& dilation) {
  const T size2 = max(dot(axes.x, axes.x), dot(axes.y, axes.y));
  const T size = sqrt(max(size2, T(1)));
  const T inverse = T(1) / size;
  const Vec3<T> ax = axes.x * inverse, ay = axes.y * inverse;
  const T d = dilation * inverse * inverse;
  const T xx = dot(ax, ax), yy = dot(ay, ay), xy = dot(ax, ay);
  const Vec3<T> c = cross(ax, ay);
  const T det = dot(c, c) + d * (xx + yy) + d * d;
  const T var_x = xx + d, var_y = yy + d;
  const T dev_y = sqrt(var_y);
  const T lambda_xx = sqrt(var_y / det);
  return {lambda_xx * inverse, -(lambda_xx * (xy / var_y)) * inverse, inverse / dev_y,
          sqrt(var_x) * size, dev_y * size};
}

/// κ = √(det Σ / det Σ′), 0…1: the factor of the opacity of a ScreenFilter that compensates. With
/// det Σ = |ax×ay|², never ad − b², as above.
template <class T>
T opacity_compensation(const ScreenAxes<T>& axes, const T& dilation) {
  const T size2 = max(dot(axes.x, axes.x), dot(axes.y, axes.y));
  const T inverse = T(1) / sqrt(max(size2, T(1)));
  const Vec3<T> ax = axes.x * inverse, ay = axes.y * inverse;
  const T d = dilation * inverse * inverse;
  const Vec3<T> c = cross(ax, ay);
  const T det = dot(c, c);
  return sqrt(det / (det + d * (dot(ax, ax) + dot(ay, ay)) + d * d));
}

}  // namespace fluxgs::math
