#include "render/scene_packing.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include <glm/common.hpp>

#include "fluxgs/math/projection.h"
#include "fluxgs/math/spherical_harmonics.h"

namespace fluxgs::render {
namespace {

// Deviations are cut at a length that covers any image evenly, unless the splat itself lies farther
// away than that.
constexpr double kLargestScale = 1e10;
constexpr double kNoLevel = -1e30;  // shaders/projected_splat.glsl
constexpr std::array<float, 4> kNoSplat = {0, 0, 0, static_cast<float>(kNoLevel)};

bool usable(float v) { return std::fabs(v) <= kLargestDrawable; }  // false for NaN and infinities
bool usable(const glm::vec3& v) { return usable(v.x) && usable(v.y) && usable(v.z); }

bool is_finite_half(std::uint16_t v) {
  constexpr std::uint16_t kExponent = 0x7C00;
  return (v & kExponent) != kExponent;
}

bool is_drawable(const RenderCloud& cloud, std::size_t i) {
  const SplatCloud& base = cloud.base;
  const glm::quat& q = base.rotations[i];
  const bool rotation =
      std::isfinite(q.w) && std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z);
  if (!rotation || !usable(base.positions[i]) || !usable(base.log_scales[i]) ||
      !std::isfinite(base.opacity_logits[i]) || !usable(base.sh_dc[i])) {
    return false;
  }
  const auto first = cloud.sh.begin() + static_cast<std::ptrdiff_t>(i * cloud.sh_size());
  return std::all_of(first, first + static_cast<std::ptrdiff_t>(cloud.sh_size()), is_finite_half);
}

float deviation(float log_scale) {
  return static_cast<float>(std::min(std::exp(static_cast<double>(log_scale)), kLargestScale));
}

/// Place of a splat's coefficients, as shaders/project.comp reads it.
float sh_word(std::size_t first, int degree) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(4 * first) |
                              static_cast<std::uint32_t>(degree));
}

}  // namespace

std::uint64_t count_of(const DegreeCounts& splats) {
  return std::accumulate(splats.begin(), splats.end(), std::uint64_t{0});
}

std::uint64_t sh_bytes(const DegreeCounts& splats) {
  std::uint64_t words = 0;
  for (int degree = 0; degree < 4; ++degree)
    words += sh_stride(degree) * std::uint64_t{splats[static_cast<std::size_t>(degree)]};
  return sizeof(PackedSplats::sh[0]) * words;
}

DegreeCounts largest_of(const DegreeCounts& scene, std::uint64_t count) {
  DegreeCounts largest{};
  for (std::size_t degree = 4; degree-- > 0;) {
    largest[degree] = static_cast<std::size_t>(std::min<std::uint64_t>(scene[degree], count));
    count -= largest[degree];
  }
  return largest;
}

std::uint64_t with_sh_in(std::uint64_t bytes, const DegreeCounts& scene) {
  std::uint64_t count = 0;
  for (int degree = 3; degree >= 0; --degree) {
    const std::uint64_t all = scene[static_cast<std::size_t>(degree)];
    const std::uint64_t each = sizeof(PackedSplats::sh[0]) * sh_stride(degree);
    const std::uint64_t fit = each > 0 ? std::min(all, bytes / each) : all;
    count += fit;
    bytes -= fit * each;
    if (fit < all) break;
  }
  return count;
}

DegreeCounts limited(const DegreeCounts& scene, int sh_degree) {
  DegreeCounts result{};
  for (std::size_t degree = 0; degree < scene.size(); ++degree)
    result[std::min(degree, static_cast<std::size_t>(sh_degree))] += scene[degree];
  return result;
}

ScenePacker::ScenePacker(const RenderCloud& cloud,
                         std::optional<std::span<const std::uint32_t>> splats, int max_sh_degree)
    : cloud_(cloud),
      splats_(splats),
      drawable_(splats ? splats->size() : cloud.size()),
      degree_(drawable_.size()) {
  constants_.count = static_cast<std::uint32_t>(drawable_.size());
  constants_.sh_degree = std::min(cloud.sh_degree, max_sh_degree);
  constants_.filter = cloud.base.filter;
  for (std::size_t k = 0; k < drawable_.size(); ++k) {
    degree_[k] = static_cast<std::uint8_t>(std::min(sh_degree_of(cloud, splat(k)), max_sh_degree));
    ++degrees_[degree_[k]];
    drawable_[k] = is_drawable(cloud, splat(k));
    if (!drawable_[k]) ++undrawable_;
  }
  if (undrawable_ == drawable_.size()) return;
  find_median();
  find_box();
}

// Over the drawable splats only, so that the others cannot move anything.
void ScenePacker::find_median() {
  std::vector<float> values;
  values.reserve(drawable_.size() - undrawable_);
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (std::size_t k = 0; k < drawable_.size(); ++k)
      if (drawable_[k]) values.push_back(cloud_.base.positions[splat(k)][axis]);
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    constants_.origin[axis] = static_cast<double>(*middle);
  }
}

void ScenePacker::find_box() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  glm::dvec3 lowest(kInfinity), highest(-kInfinity);
  for (std::size_t k = 0; k < drawable_.size(); ++k) {
    if (!drawable_[k]) continue;
    const glm::dvec3 p(position(splat(k)));
    lowest = glm::min(lowest, p);
    highest = glm::max(highest, p);
  }
  constants_.lowest = lowest;
  constants_.highest = highest;
}

/// All but the word of the SH coefficients.
void ScenePacker::pack_geometry(std::size_t i, std::array<float, 4>* out) const {
  const glm::vec3 p = position(i);
  const glm::vec3& s = cloud_.base.log_scales[i];
  const glm::quat& quat = cloud_.base.rotations[i];
  const auto q = math::normalized(math::Quat<double>{quat.w, quat.x, quat.y, quat.z});
  const glm::dvec3 color = 0.5 + math::kSh0 * glm::dvec3(cloud_.base.sh_dc[i]);
  // log2 of the opacity, the logistic function of the logit
  const double level =
      -std::log2(1 + std::exp(-static_cast<double>(cloud_.base.opacity_logits[i])));
  out[0] = {p.x, p.y, p.z, static_cast<float>(std::max(level, kNoLevel))};
  out[1] = {deviation(s.x), deviation(s.y), deviation(s.z), static_cast<float>(color.r)};
  out[2] = {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z),
            static_cast<float>(q.w)};
  out[3] = {static_cast<float>(color.g), static_cast<float>(color.b), 0.0F, out[3][3]};
}

// Groups of four coefficients, zeros behind the last.
void ScenePacker::pack_sh(std::size_t i, int degree, std::uint64_t* out) const {
  const std::size_t own =
      3 * sizeof(std::uint16_t) * static_cast<std::size_t>(sh_rest_count(degree));
  std::fill_n(out, sh_stride(degree), 0);
  if (own > 0) std::memcpy(out, cloud_.sh.data() + i * cloud_.sh_size(), own);
}

void ScenePacker::next(std::size_t most, PackedSplats& part) {
  const std::size_t first = packed_;
  packed_ += std::min(most, drawable_.size() - packed_);
  part.geometry.assign(4 * (packed_ - first), kNoSplat);
  part.sh.clear();
  for (std::size_t k = first; k < packed_; ++k) {
    const std::size_t i = splat(k);
    const int degree = degree_[k];
    auto* const geometry = &part.geometry[4 * (k - first)];
    const std::size_t sh = part.sh.size();
    part.sh.resize(sh + sh_stride(degree));
    geometry[3][3] = sh_word(sh_ + sh, degree);
    if (!drawable_[k]) continue;  // keeps its place all the same
    pack_geometry(i, geometry);
    pack_sh(i, degree, part.sh.data() + sh);
  }
  sh_ += part.sh.size();
}

void add_positions(const PackedSplats& part, std::vector<glm::vec3>& positions) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t k = 0; k < part.geometry.size(); k += 4) {
    const auto& at = part.geometry[k];
    const bool drawn = static_cast<double>(at[3]) > kNoLevel;
    positions.push_back(drawn ? glm::vec3(at[0], at[1], at[2]) : glm::vec3(kNan));
  }
}

}  // namespace fluxgs::render
