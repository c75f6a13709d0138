#include "tools/reference/reference_renderer.h"

#include <algorithm>
#include <cmath>

#include "fluxgs/math/projection.h"
#include "fluxgs/math/spherical_harmonics.h"

namespace fluxgs {
namespace {

math::Vec3<double> vec(const glm::vec3& v) { return {v.x, v.y, v.z}; }

void shade(const SplatCloud& cloud, std::size_t i, const math::View<double>& view, int max_degree,
           ReferenceSplat& out) {
  const math::Vec3<double> ray = vec(cloud.positions[i]) - view.center;
  const double length = std::sqrt(dot(ray, ray));
  const math::Vec3<double> direction = ray * (length > 0 ? 1 / length : 0.0);
  const int degree = std::min(cloud.sh_degree, max_degree);
  const std::size_t stored = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  double basis[15];
  math::sh_basis(degree, direction, basis);
  for (int c = 0; c < 3; ++c) {
    double color = 0.5 + math::kSh0 * static_cast<double>(cloud.sh_dc[i][c]);
    for (int k = 0; k < sh_rest_count(degree); ++k)
      color += basis[k] *
               static_cast<double>(cloud.sh_rest[i * stored + static_cast<std::size_t>(k)][c]);
    out.clamped[c] = color < 0;
    out.color[c] = std::max(color, 0.0);
  }
}

bool finite(const ReferenceSplat& s) {
  const double sum = s.x + s.y + s.depth + s.xx + s.xy + s.yy + s.half_width + s.half_height +
                     s.color[0] + s.color[1] + s.color[2];
  return std::isfinite(sum);
}

}  // namespace

std::vector<ReferenceSplat> project_reference(const SplatCloud& cloud, const Camera& camera,
                                              const RenderOptions& asked) {
  const RenderOptions options = for_scene(asked, cloud.filter);
  const auto view = math::make_view<double>(camera, options);
  std::vector<ReferenceSplat> splats;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!is_finite(cloud, i)) continue;
    const math::Vec3<double> p = view.rotation * vec(cloud.positions[i]) + view.translation;
    if (!(p.z > options.near_plane)) continue;
    ReferenceSplat s{};
    s.opacity = 1 / (1 + std::exp(-static_cast<double>(cloud.opacity_logits[i])));
    const glm::quat& q = cloud.rotations[i];
    const auto rotation =
        math::rotation_matrix(math::normalized(math::Quat<double>{q.w, q.x, q.y, q.z}));
    const glm::vec3 l = cloud.log_scales[i];
    const math::Vec3<double> scale{std::exp(double{l.x}), std::exp(double{l.y}),
                                   std::exp(double{l.z})};
    const double spread = math::depth_deviation(view.rotation.row2, rotation, scale);
    if (!(spread <= view.depth_spread_max * p.z)) continue;
    const auto axes =
        math::screen_axes(math::projection_jacobian(p, view), view.rotation, rotation, scale);
    s.compensation = view.compensated ? math::opacity_compensation(axes, view.dilation) : 1;
    s.opacity *= s.compensation;
    if (!(s.opacity >= options.alpha_min)) continue;
    const auto f = math::footprint(axes, view.dilation);
    const double radius = std::sqrt(2 * std::log(s.opacity / options.alpha_min));

    s.index = static_cast<std::uint32_t>(i);
    s.x = camera.fx * p.x / p.z + camera.cx;
    s.y = camera.fy * p.y / p.z + camera.cy;
    s.depth = p.z;
    s.xx = f.xx, s.xy = f.xy, s.yy = f.yy;
    s.half_width = radius * f.deviation_x;
    s.half_height = radius * f.deviation_y;
    shade(cloud, i, view, options.sh_degree, s);
    if (finite(s)) splats.push_back(s);
  }
  std::stable_sort(splats.begin(), splats.end(),
                   [](const auto& a, const auto& b) { return a.depth < b.depth; });
  return splats;
}

ReferenceImage render_reference(const SplatCloud& cloud, const Camera& camera,
                                const RenderOptions& options) {
  ReferenceImage image{Image<double>(camera.width, camera.height, 3),
                       Image<double>(camera.width, camera.height, 1)};
  std::fill(image.transmittance.pixels.begin(), image.transmittance.pixels.end(), 1.0);

  for (const ReferenceSplat& s : project_reference(cloud, camera, options)) {
    const auto first = [](double at) { return std::max(0.0, std::floor(at - 0.5)); };
    const auto last = [](double at, int size) { return std::min(size - 1.0, std::ceil(at)); };
    for (double y = first(s.y - s.half_height); y <= last(s.y + s.half_height, camera.height);
         ++y) {
      for (double x = first(s.x - s.half_width); x <= last(s.x + s.half_width, camera.width); ++x) {
        const double dx = x + 0.5 - s.x, dy = y + 0.5 - s.y;
        const double u = s.xx * dx + s.xy * dy, v = s.yy * dy;
        const double alpha =
            std::min(options.alpha_max, s.opacity * std::exp(-0.5 * (u * u + v * v)));
        double& t = *image.transmittance.at(static_cast<int>(x), static_cast<int>(y));
        if (alpha < options.alpha_min || t < options.transmittance_min) continue;
        double* color = image.color.at(static_cast<int>(x), static_cast<int>(y));
        for (int c = 0; c < 3; ++c) color[c] += s.color[c] * alpha * t;
        t *= 1 - alpha;
      }
    }
  }
  for (std::size_t i = 0; i < image.transmittance.pixels.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      image.color.pixels[3 * i + c] +=
          image.transmittance.pixels[i] * options.background[static_cast<int>(c)];
  return image;
}

Image<std::uint8_t> in_bytes(const Image<double>& color) {
  Image<std::uint8_t> bytes(color.width, color.height, color.channels);
  std::ranges::transform(color.pixels, bytes.pixels.begin(), [](double value) {
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
  });
  return bytes;
}

}  // namespace fluxgs
