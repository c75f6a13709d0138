#include "bench/traffic_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "render/scene_buffers.h"

namespace fluxgs::bench {
namespace {

using render::RendererSettings;
using render::SorterKind;
using render::TargetPlan;

constexpr double kWord = 4, kVec4 = 16;

double project_bytes(const FrameCounts& c, const RendererSettings& s) {
  const auto splats = static_cast<double>(c.splats), in_front = static_cast<double>(c.in_front);
  const auto drawn = static_cast<double>(c.drawn);
  const double read =
      splats * kVec4 + in_front * 3 * kVec4 + static_cast<double>(render::sh_bytes(c.evaluated));
  const double marks = (splats - drawn) * kWord;  // of those that are hidden
  return read + splats * kWord + marks +
         drawn * static_cast<double>(projected_splat_bytes(s.splat_precision));
}

double gpu_sort_bytes(const FrameCounts& c, int digit_bits) {
  const auto splats = static_cast<double>(c.splats), drawn = static_cast<double>(c.drawn);
  const double radix = std::exp2(digit_bits);
  const auto tables = [&](double keys) {  // written, scanned in place, read
    return std::ceil(keys / 2048) * radix * kWord * 5;
  };
  const int passes = std::max(2, (c.key_bits + digit_bits - 1) / digit_bits);
  double bytes = tables(splats) + splats * 2 * kWord + drawn * 2 * kWord;
  for (int pass = 1; pass < passes; ++pass) {
    const bool last = pass + 1 == passes;
    // Pairs are counted, read again, and written as pairs or as indices
    bytes += tables(drawn) + drawn * (2 * kWord + 2 * kWord + (last ? kWord : 2 * kWord));
  }
  return bytes;
}

double sort_bytes(const FrameCounts& c, const RendererSettings& s) {
  if (s.sorter == SorterKind::gpu_radix) return gpu_sort_bytes(c, s.sort_digit_bits);
  return 2 * kWord * static_cast<double>(c.splats);  // The upload of an order, written and read
}

}  // namespace

FrameTraffic model_traffic(const FrameCounts& c, const RendererSettings& s, const TargetPlan& t) {
  const double pixels = static_cast<double>(t.width) * t.height;
  const double blended =
      std::max(1.0, std::round(t.width * t.scale)) * std::max(1.0, std::round(t.height * t.scale));
  const auto shown_bytes = static_cast<double>(render::pixel_bytes(t.format));
  const auto blend_bytes = static_cast<double>(render::blend_pixel_bytes(t));
  const bool resolves = blend_bytes != shown_bytes || blended != pixels;
  const auto drawn = static_cast<double>(c.drawn);
  return {
      .project = project_bytes(c, s),
      .sort = sort_bytes(c, s),
      .vertices = drawn * (kWord + static_cast<double>(projected_splat_bytes(s.splat_precision))),
      .resolve = resolves ? blended * blend_bytes + pixels * shown_bytes : 0,
      .blend_tiled = blended * blend_bytes,
      .blend_immediate = (2 * c.fragments + blended) * blend_bytes};
}

namespace {

struct Point {
  double x, y;
};

// Sutherland and Hodgman's clipping of a convex polygon against one side: inside(p) ≥ 0.
template <class Side>
void clip(std::vector<Point>& polygon, const Side& inside) {
  std::vector<Point> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point& a = polygon[i];
    const Point& b = polygon[(i + 1) % polygon.size()];
    const double da = inside(a), db = inside(b);
    if (da >= 0) kept.push_back(a);
    if ((da < 0) != (db < 0)) {
      const double t = da / (da - db);
      kept.push_back({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)});
    }
  }
  polygon = std::move(kept);
}

}  // namespace

double area_inside(const Quad& quad, int width, int height) {
  std::vector<Point> polygon;
  for (int i = 0; i < 4; ++i) polygon.push_back({quad.x[i], quad.y[i]});
  clip(polygon, [](const Point& p) { return p.x; });
  clip(polygon, [](const Point& p) { return p.y; });
  clip(polygon, [&](const Point& p) { return width - p.x; });
  clip(polygon, [&](const Point& p) { return height - p.y; });
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point& a = polygon[i];
    const Point& b = polygon[(i + 1) % polygon.size()];
    twice += a.x * b.y - b.x * a.y;
  }
  return std::abs(twice) / 2;
}

}  // namespace fluxgs::bench
