#include "render/scene_packing.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/gtc/packing.hpp>

#include "fluxgs/math/projection.h"
#include "fluxgs/math/spherical_harmonics.h"

namespace fluxgs::render {
namespace {

// Larger numbers than this cannot be projected in float32 without overflow. Deviations are cut at a
// length that covers any image evenly, unless the splat itself lies farther away than that.
constexpr float kLargest = 1e15F;
constexpr float kLargestHalf = 65504;
constexpr double kLargestScale = 1e10;
constexpr double kNoLevel = -1e30;  // shaders/projected_splat.glsl
constexpr std::array<float, 4> kNoSplat = {0, 0, 0, static_cast<float>(kNoLevel)};

bool usable(float v) { return std::fabs(v) <= kLargest; }  // false for NaN and infinities
bool usable(const glm::vec3& v) { return usable(v.x) && usable(v.y) && usable(v.z); }

bool is_drawable(const SplatCloud& cloud, std::size_t i) {
  const glm::quat& q = cloud.rotations[i];
  const bool rotation =
      std::isfinite(q.w) && std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z);
  if (!rotation || !usable(cloud.positions[i]) || !usable(cloud.log_scales[i]) ||
      !std::isfinite(cloud.opacity_logits[i]) || !usable(cloud.sh_dc[i])) {
    return false;
  }
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  const auto first = cloud.sh_rest.begin() + static_cast<std::ptrdiff_t>(i * rest);
  return std::all_of(first, first + static_cast<std::ptrdiff_t>(rest),
                     [](const glm::vec3& c) { return usable(c); });
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

ScenePacker::ScenePacker(const SplatCloud& cloud,
                         std::optional<std::span<const std::uint32_t>> splats)
    : cloud_(cloud),
      splats_(splats),
      drawable_(splats ? splats->size() : cloud.size()),
      degree_(drawable_.size()) {
  constants_.count = static_cast<std::uint32_t>(drawable_.size());
  constants_.sh_degree = cloud.sh_degree;
  constants_.filter = cloud.filter;
  for (std::size_t k = 0; k < drawable_.size(); ++k) {
    degree_[k] = static_cast<std::uint8_t>(sh_degree_of(cloud, splat(k)));
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
      if (drawable_[k]) values.push_back(cloud_.positions[splat(k)][axis]);
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
  const glm::vec3& s = cloud_.log_scales[i];
  const glm::quat& quat = cloud_.rotations[i];
  const auto q = math::normalized(math::Quat<double>{quat.w, quat.x, quat.y, quat.z});
  const glm::dvec3 color = 0.5 + math::kSh0 * glm::dvec3(cloud_.sh_dc[i]);
  // log2 of the opacity, the logistic function of the logit
  const double level = -std::log2(1 + std::exp(-static_cast<double>(cloud_.opacity_logits[i])));
  out[0] = {p.x, p.y, p.z, static_cast<float>(std::max(level, kNoLevel))};
  out[1] = {deviation(s.x), deviation(s.y), deviation(s.z), static_cast<float>(color.r)};
  out[2] = {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z),
            static_cast<float>(q.w)};
  out[3] = {static_cast<float>(color.g), static_cast<float>(color.b), 0.0F, out[3][3]};
}

void ScenePacker::pack_sh(std::size_t i, int degree, std::uint64_t* out) const {
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud_.sh_degree));
  const auto own = static_cast<std::size_t>(sh_rest_count(degree));
  std::array<float, 48> values{};
  for (std::size_t k = 0; k < own; ++k)
    for (std::size_t c = 0; c < 3; ++c)
      values[3 * k + c] = cloud_.sh_rest[i * rest + k][static_cast<int>(c)];
  for (std::size_t k = 0; k < sh_stride(degree); ++k) {
    const glm::vec4 four(values[4 * k], values[4 * k + 1], values[4 * k + 2], values[4 * k + 3]);
    out[k] = glm::packHalf4x16(glm::clamp(four, -kLargestHalf, kLargestHalf));
  }
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
