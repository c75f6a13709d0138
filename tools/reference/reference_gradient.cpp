#include "tools/reference/reference_gradient.h"

#include <algorithm>
#include <cmath>

#include "fluxgs/math/projection_gradient.h"

namespace fluxgs {
namespace {

/// Contribution of one splat to one pixel.
struct Contribution {
  std::uint32_t splat;  // position in the sorted list
  double u, v, alpha, transmittance;
  bool limited;  // by α_max
};

/// Sums of the pixels' gradients for one splat.
struct Sums {
  math::FootprintMoments<double> moments{};
  double h = 0;  // Σ α·∂L/∂α
  double color[3] = {0, 0, 0};
};

std::vector<Contribution> contributions(const std::vector<ReferenceSplat>& splats, int x, int y,
                                        const RenderOptions& options) {
  std::vector<Contribution> list;
  double t = 1;
  for (std::uint32_t i = 0; i < splats.size() && t >= options.transmittance_min; ++i) {
    const ReferenceSplat& s = splats[i];
    const double dx = x + 0.5 - s.x, dy = y + 0.5 - s.y;
    if (std::abs(dx) > s.half_width + 1 || std::abs(dy) > s.half_height + 1) continue;
    const double u = s.xx * dx + s.xy * dy, v = s.yy * dy;
    const double raw = s.opacity * std::exp(-0.5 * (u * u + v * v));
    const double alpha = std::min(options.alpha_max, raw);
    if (alpha < options.alpha_min) continue;
    list.push_back({i, u, v, alpha, t, raw > options.alpha_max});
    t *= 1 - alpha;
  }
  return list;
}

void accumulate_pixel(const std::vector<ReferenceSplat>& splats,
                      const std::vector<Contribution>& list, const double* g,
                      const glm::dvec3& background, std::vector<Sums>& sums) {
  // What lies behind a splat, as seen through it: starts with the background.
  double behind[3] = {background.x, background.y, background.z};
  for (auto it = list.rbegin(); it != list.rend(); ++it) {
    const ReferenceSplat& s = splats[it->splat];
    Sums& sum = sums[it->splat];
    double d_alpha = 0;
    for (int c = 0; c < 3; ++c) {
      d_alpha += g[c] * it->transmittance * (s.color[c] - behind[c]);
      sum.color[c] += g[c] * it->transmittance * it->alpha;
      behind[c] = it->alpha * s.color[c] + (1 - it->alpha) * behind[c];
    }
    if (it->limited) continue;
    const double h = it->alpha * d_alpha;
    sum.h += h;
    sum.moments.u += h * it->u;
    sum.moments.v += h * it->v;
    sum.moments.uu += h * it->u * it->u;
    sum.moments.uv += h * it->u * it->v;
    sum.moments.vv += h * it->v * it->v;
  }
}

void backpropagate_color(const SplatCloud& cloud, const ReferenceSplat& s, const Sums& sums,
                         const math::View<double>& view, int max_degree, ReferenceGradient& out) {
  const std::size_t i = s.index;
  const int degree = std::min(cloud.sh_degree, max_degree);
  const std::size_t stored = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  const glm::vec3 at = cloud.positions[i];
  const math::Vec3<double> ray = math::Vec3<double>{at.x, at.y, at.z} - view.center;
  const double length = std::sqrt(dot(ray, ray));
  const math::Vec3<double> direction = ray * (length > 0 ? 1 / length : 0.0);
  double basis[15];
  math::Vec3<double> slopes[15];
  math::sh_basis(degree, direction, basis);
  math::sh_basis_gradient(degree, direction, slopes);
  math::Vec3<double> d_direction{0, 0, 0};
  for (int c = 0; c < 3; ++c) {
    if (s.clamped[c]) continue;
    const auto channel = static_cast<std::size_t>(c);
    out.sh_dc[i][channel] += math::kSh0 * sums.color[c];
    for (int k = 0; k < sh_rest_count(degree); ++k) {
      const std::size_t at_k = i * stored + static_cast<std::size_t>(k);
      out.sh_rest[at_k][channel] += basis[k] * sums.color[c];
      d_direction = d_direction + slopes[k] * (sums.color[c] * double{cloud.sh_rest[at_k][c]});
    }
  }
  const auto d_position = math::direction_gradient(ray, d_direction);
  out.positions[i][0] += d_position.x;
  out.positions[i][1] += d_position.y;
  out.positions[i][2] += d_position.z;
}

void backpropagate_geometry(const SplatCloud& cloud, const ReferenceSplat& s, const Sums& sums,
                            const math::View<double>& view, ReferenceGradient& out) {
  const std::size_t i = s.index;
  const glm::vec3 at = cloud.positions[i], l = cloud.log_scales[i];
  const glm::quat q = cloud.rotations[i];
  const math::Vec3<double> p =
      view.rotation * math::Vec3<double>{at.x, at.y, at.z} + view.translation;
  const auto footprint = math::footprint_gradient(sums.moments, sums.h, s.xx, s.xy, s.yy);
  const auto g = math::geometry_gradient(
      footprint, p, math::Quat<double>{q.w, q.x, q.y, q.z},
      math::Vec3<double>{std::exp(double{l.x}), std::exp(double{l.y}), std::exp(double{l.z})},
      view);
  out.positions[i][0] += g.position.x;
  out.positions[i][1] += g.position.y;
  out.positions[i][2] += g.position.z;
  out.log_scales[i] = {g.log_scale.x, g.log_scale.y, g.log_scale.z};
  out.rotations[i] = {g.rotation.w, g.rotation.x, g.rotation.y, g.rotation.z};
  out.opacity_logits[i] = sums.h * (1 - s.opacity / s.compensation);
  out.centers[i] = {footprint.x, footprint.y};
}

}  // namespace

ReferenceGradient reference_gradient(const SplatCloud& cloud, const Camera& camera,
                                     const RenderOptions& options,
                                     const Image<double>& pixel_gradient) {
  const auto splats = project_reference(cloud, camera, options);
  std::vector<Sums> sums(splats.size());
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      accumulate_pixel(splats, contributions(splats, x, y, options), pixel_gradient.at(x, y),
                       options.background, sums);

  const std::size_t n = cloud.size();
  ReferenceGradient out;
  out.positions.resize(n);
  out.log_scales.resize(n);
  out.sh_dc.resize(n);
  out.rotations.resize(n);
  out.opacity_logits.resize(n);
  out.sh_rest.resize(cloud.sh_rest.size());
  out.centers.resize(n);
  const auto view = math::make_view<double>(camera, for_scene(options, cloud.filter));
  for (std::size_t k = 0; k < splats.size(); ++k) {
    backpropagate_color(cloud, splats[k], sums[k], view, options.sh_degree, out);
    backpropagate_geometry(cloud, splats[k], sums[k], view, out);
  }
  return out;
}

}  // namespace fluxgs
