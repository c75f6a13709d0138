#include "render/render_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>

#include "fluxgs/morton.h"
#include "render/scene_packing.h"

namespace fluxgs::render {
namespace {

constexpr float kLargestHalf = 65504;
constexpr std::uint16_t kHalfMagnitude = 0x7FFF;

/// Numbers that no splat may have that is drawn become infinite.
std::uint16_t half(float v) {
  return glm::packHalf1x16(
      std::fabs(v) <= kLargestDrawable ? std::clamp(v, -kLargestHalf, kLargestHalf) : v);
}

void append_sh(std::span<const glm::vec3> from, std::size_t halves,
               std::vector<std::uint16_t>& to) {
  for (const glm::vec3& c : from)
    for (int channel = 0; channel < 3; ++channel) to.push_back(half(c[channel]));
  to.resize(to.size() + halves - 3 * from.size());
}

void append_sh(const SplatCloud& from, std::size_t i, RenderCloud& to) {
  const auto rest = static_cast<std::size_t>(sh_rest_count(from.sh_degree));
  append_sh(std::span(from.sh_rest).subspan(i * rest, rest), to.sh_size(), to.sh);
}

/// Applies an order to a list of `size` values for each splat, in place: along its cycles.
template <class T>
void permute(std::vector<T>& values, std::size_t size, std::span<const std::uint32_t> order) {
  if (values.empty()) return;
  std::array<T, 45> first;
  const auto at = [&](std::size_t i) {
    return values.begin() + static_cast<std::ptrdiff_t>(i * size);
  };
  std::vector<bool> done(order.size());
  for (std::size_t begin = 0; begin < order.size(); ++begin) {
    if (done[begin]) continue;
    std::copy_n(at(begin), size, first.begin());
    std::size_t to = begin;
    for (; order[to] != begin; to = order[to]) {
      std::copy_n(at(order[to]), size, at(to));
      done[to] = true;
    }
    std::copy_n(first.begin(), size, at(to));
    done[to] = true;
  }
}

/// Median distance of pairs of splats, as far apart in the cloud.
double median_distance(const SplatCloud& cloud, std::size_t apart) {
  constexpr std::size_t kPairs = 4096;
  const std::size_t pairs = cloud.size() - apart, step = std::max<std::size_t>(pairs / kPairs, 1);
  std::vector<double> distances;
  for (std::size_t i = 0; i < pairs; i += step)
    distances.push_back(
        glm::distance(glm::dvec3(cloud.positions[i]), glm::dvec3(cloud.positions[i + apart])));
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::ranges::nth_element(distances, middle);
  return *middle;
}

}  // namespace

RenderCloud::RenderCloud(const SplatCloud& cloud) : RenderCloud(SplatCloud(cloud)) {}

RenderCloud::RenderCloud(SplatCloud&& cloud)
    : base(std::move(cloud)),
      sh_degree(base.sh_degree),
      file_splats(base.size()),
      file_sh_degree(base.sh_degree) {
  sh.reserve(3 * base.sh_rest.size());
  append_sh(base.sh_rest, 3 * base.sh_rest.size(), sh);
  base.sh_rest = {};
  base.sh_degree = 0;
}

SplatCloud splat_cloud_of(const RenderCloud& cloud) {
  SplatCloud result = cloud.base;
  result.sh_degree = cloud.sh_degree;
  for (std::size_t k = 0; k < cloud.sh.size(); k += 3)
    result.sh_rest.emplace_back(glm::unpackHalf1x16(cloud.sh[k]),
                                glm::unpackHalf1x16(cloud.sh[k + 1]),
                                glm::unpackHalf1x16(cloud.sh[k + 2]));
  return result;
}

void reserve(RenderCloud& cloud, std::size_t count) {
  cloud.base.positions.reserve(count);
  cloud.base.log_scales.reserve(count);
  cloud.base.rotations.reserve(count);
  cloud.base.opacity_logits.reserve(count);
  cloud.base.sh_dc.reserve(count);
  cloud.sh.reserve(count * cloud.sh_size());
}

void append(const SplatCloud& from, std::size_t i, RenderCloud& to) {
  to.base.positions.push_back(from.positions[i]);
  to.base.log_scales.push_back(from.log_scales[i]);
  to.base.rotations.push_back(from.rotations[i]);
  to.base.opacity_logits.push_back(from.opacity_logits[i]);
  to.base.sh_dc.push_back(from.sh_dc[i]);
  append_sh(from, i, to);
}

int sh_degree_of(const RenderCloud& cloud, std::size_t i) {
  const std::uint16_t* const own = cloud.sh.data() + i * cloud.sh_size();
  std::size_t used = cloud.sh_size();
  while (used > 0 && (own[used - 1] & kHalfMagnitude) == 0) --used;
  int degree = 0;
  while (3 * static_cast<std::size_t>(sh_rest_count(degree)) < used) ++degree;
  return degree;
}

bool lies_in_order(const SplatCloud& cloud) {
  // Splats that fill a cube evenly lie n^(-1/3) of its side apart. Those of a curve jump now and
  // then, and those without an order are as far apart as any two.
  constexpr double kFartherThanEven = 4;
  constexpr std::size_t kFew = 1000;  // lie in the cache in any order
  if (cloud.size() < kFew) return true;
  const double even = std::cbrt(1 / static_cast<double>(cloud.size()));
  return median_distance(cloud, 1) <=
         kFartherThanEven * even * median_distance(cloud, cloud.size() / 2);
}

void put_in_order(RenderCloud& cloud) {
  if (lies_in_order(cloud.base)) return;
  const std::vector<std::uint32_t> order = morton_order(cloud.base.positions);
  permute(cloud.base.positions, 1, order);
  permute(cloud.base.log_scales, 1, order);
  permute(cloud.base.rotations, 1, order);
  permute(cloud.base.opacity_logits, 1, order);
  permute(cloud.base.sh_dc, 1, order);
  permute(cloud.sh, cloud.sh_size(), order);
}

RenderCloud cloud_to_draw(SplatCloud&& cloud) {
  RenderCloud result(std::move(cloud));
  put_in_order(result);
  return result;
}

}  // namespace fluxgs::render
