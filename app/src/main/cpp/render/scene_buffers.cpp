#include "render/scene_buffers.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "fluxgs/math/projection.h"
#include "fluxgs/math/spherical_harmonics.h"
#include "gl/steps.h"

namespace fluxgs::render {
namespace {

// Larger numbers than this cannot be projected in float32 without overflow. Deviations are cut at a
// length that covers any picture evenly, unless the splat itself lies farther away than that.
constexpr float kLargest = 1e15F;
constexpr double kLargestScale = 1e10;
constexpr double kNoLevel = -1e30;  // shaders/record.glsl
constexpr std::uint64_t kVec4 = 16;
constexpr std::uint64_t kMostHarmonics = kVec4 << 30;  // what harmonics_word() can point into

bool usable(float v) { return std::fabs(v) <= kLargest; }  // false for NaN and infinities
bool usable(const glm::vec3& v) { return usable(v.x) && usable(v.y) && usable(v.z); }

bool drawable(const SplatCloud& cloud, std::size_t i) {
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

// Over the drawable splats only, so that the others cannot move anything.
glm::dvec3 median_position(const SplatCloud& cloud, const std::vector<std::size_t>& splats) {
  glm::dvec3 median(0.0);
  if (splats.empty()) return median;
  std::vector<float> values(splats.size());
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::transform(splats, values.begin(),
                           [&](std::size_t i) { return cloud.positions[i][axis]; });
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    median[axis] = static_cast<double>(*middle);
  }
  return median;
}

float deviation(float log_scale) {
  return static_cast<float>(std::min(std::exp(static_cast<double>(log_scale)), kLargestScale));
}

/// Where a splat's coefficients lie, as shaders/project.comp reads it.
float harmonics_word(std::size_t first, int degree) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(4 * first) |
                              static_cast<std::uint32_t>(degree));
}

/// All but the word of the harmonics.
void pack_geometry(const SplatCloud& cloud, std::size_t i, const glm::dvec3& origin,
                   std::array<float, 4>* out) {
  const glm::vec3 p(glm::dvec3(cloud.positions[i]) - origin);
  const glm::vec3& s = cloud.log_scales[i];
  const glm::quat& quat = cloud.rotations[i];
  const auto q = math::normalized(math::Quat<double>{quat.w, quat.x, quat.y, quat.z});
  const glm::dvec3 color = 0.5 + math::kSh0 * glm::dvec3(cloud.sh_dc[i]);
  // log2 of the opacity, the logistic function of the logit
  const double level = -std::log2(1 + std::exp(-static_cast<double>(cloud.opacity_logits[i])));
  out[0] = {p.x, p.y, p.z, static_cast<float>(std::max(level, kNoLevel))};
  out[1] = {deviation(s.x), deviation(s.y), deviation(s.z), static_cast<float>(color.r)};
  out[2] = {static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z),
            static_cast<float>(q.w)};
  out[3] = {static_cast<float>(color.g), static_cast<float>(color.b), 0.0F, out[3][3]};
}

void pack_harmonics(const SplatCloud& cloud, std::size_t i, int degree, std::array<float, 4>* out) {
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  const auto own = static_cast<std::size_t>(sh_rest_count(degree));
  for (std::size_t k = 0; k < own; ++k)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t at = 3 * k + c;
      out[at / 4][at % 4] = cloud.sh_rest[i * rest + k][static_cast<int>(c)];
    }
}

void find_box(PackedScene& scene, const std::vector<std::size_t>& splats) {
  if (splats.empty()) return;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  glm::dvec3 lowest(kInfinity), highest(-kInfinity);
  for (const std::size_t i : splats) {
    const auto& at = scene.geometry[4 * i];
    const glm::dvec3 p(at[0], at[1], at[2]);
    lowest = glm::min(lowest, p);
    highest = glm::max(highest, p);
  }
  scene.constants.lowest = lowest;
  scene.constants.highest = highest;
}

/// How many of largest_of() have all their coefficients in that many bytes.
std::uint64_t with_harmonics_in(std::uint64_t bytes, const DegreeCounts& scene) {
  std::uint64_t count = 0;
  for (int degree = 3; degree >= 0; --degree) {
    const std::uint64_t all = scene[static_cast<std::size_t>(degree)];
    const std::uint64_t each = kVec4 * harmonics_stride(degree);
    const std::uint64_t fit = each > 0 ? std::min(all, bytes / each) : all;
    count += fit;
    bytes -= fit * each;
    if (fit < all) break;
  }
  return count;
}

Expected<void> check_size(const gl::Capabilities& driver, const SplatCloud& cloud) {
  const std::uint64_t most = most_splats(driver, count_degrees(cloud));
  if (cloud.size() <= most) return {};
  return fail("scene", "size",
              std::to_string(cloud.size()) + " splats of degree " +
                  std::to_string(cloud.sh_degree) + " are too many for " + driver.renderer +
                  ": it can hold " + std::to_string(most));
}

}  // namespace

Expected<void> check_cloud(const SplatCloud& cloud) {
  if (cloud.sh_degree < 0 || cloud.sh_degree > 3) {
    return fail("scene", "sh_degree",
                std::to_string(cloud.sh_degree) + "; 0, 1, 2 or 3 was expected");
  }
  const std::size_t n = cloud.size();
  const bool complete =
      cloud.log_scales.size() == n && cloud.rotations.size() == n &&
      cloud.opacity_logits.size() == n && cloud.sh_dc.size() == n &&
      cloud.sh_rest.size() == n * static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  if (complete) return {};
  return fail("scene", "attributes", "every splat must have all of them");
}

PackedScene pack_scene(const SplatCloud& cloud) {
  std::vector<std::size_t> splats;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (drawable(cloud, i)) splats.push_back(i);

  PackedScene scene;
  scene.constants.count = static_cast<std::uint32_t>(cloud.size());
  scene.constants.sh_degree = cloud.sh_degree;
  scene.constants.origin = median_position(cloud, splats);
  scene.geometry.assign(4 * cloud.size(), {0, 0, 0, static_cast<float>(kNoLevel)});
  scene.harmonics.reserve(harmonics_bytes(count_degrees(cloud)) / sizeof(scene.harmonics[0]));
  scene.undrawable = cloud.size() - splats.size();
  auto drawn = splats.begin();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const int degree = sh_degree_of(cloud, i);
    const std::size_t first = scene.harmonics.size();
    scene.harmonics.resize(first + harmonics_stride(degree));
    scene.geometry[4 * i + 3][3] = harmonics_word(first, degree);
    if (drawn == splats.end() || *drawn != i) continue;  // keeps its place all the same
    ++drawn;
    pack_geometry(cloud, i, scene.constants.origin, &scene.geometry[4 * i]);
    pack_harmonics(cloud, i, degree, scene.harmonics.data() + first);
  }
  find_box(scene, splats);
  return scene;
}

std::vector<glm::vec3> positions_of(const PackedScene& scene) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  std::vector<glm::vec3> positions(scene.constants.count, glm::vec3(kNan));
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const auto& at = scene.geometry[4 * i];
    if (static_cast<double>(at[3]) > kNoLevel) positions[i] = {at[0], at[1], at[2]};
  }
  return positions;
}

std::uint64_t harmonics_bytes(const DegreeCounts& splats) {
  std::uint64_t vectors = 0;
  for (int degree = 0; degree < 4; ++degree)
    vectors += harmonics_stride(degree) * std::uint64_t{splats[static_cast<std::size_t>(degree)]};
  return kVec4 * vectors;
}

DegreeCounts largest_of(const DegreeCounts& scene, std::uint64_t count) {
  DegreeCounts largest{};
  for (std::size_t degree = 4; degree-- > 0;) {
    largest[degree] = static_cast<std::size_t>(std::min<std::uint64_t>(scene[degree], count));
    count -= largest[degree];
  }
  return largest;
}

std::uint64_t most_splats(const gl::Capabilities& driver, const DegreeCounts& scene) {
  const auto block = static_cast<std::uint64_t>(driver.max_storage_block_bytes);
  const auto by_groups = static_cast<std::uint64_t>(driver.max_work_groups_x) * 128 - 1;
  return std::min({block / (4 * kVec4), by_groups, std::uint64_t{0xFFFF0000},
                   with_harmonics_in(std::min(block, kMostHarmonics), scene)});
}

Expected<void> check_scene(const gl::Capabilities& driver, const SplatCloud& cloud) {
  return gl::in_turn([&] { return check_cloud(cloud); }, [&] { return check_size(driver, cloud); });
}

Expected<SceneBuffers> SceneBuffers::create(gl::Api& api, const PackedScene& scene) {
  SceneBuffers buffers;
  buffers.constants = scene.constants;
  const auto upload = [&](const auto& values, gl::Buffer& into) {
    const std::size_t bytes = values.size() * sizeof(values[0]);
    return into.remake(api, bytes, values.data(), GL_STATIC_DRAW);
  };
  auto done = gl::in_turn([&] { return upload(scene.geometry, buffers.geometry); },
                          [&] { return upload(scene.harmonics, buffers.harmonics); });
  if (!done) return std::unexpected(done.error());
  return buffers;
}

}  // namespace fluxgs::render
