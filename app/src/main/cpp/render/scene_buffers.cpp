#include "render/scene_buffers.h"

#include <algorithm>
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
  out[3] = {static_cast<float>(color.g), static_cast<float>(color.b), 0.0F, 0.0F};
}

void pack_harmonics(const SplatCloud& cloud, std::size_t i, std::array<float, 4>* out) {
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (std::size_t k = 0; k < rest; ++k)
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t at = 3 * k + c;
      out[at / 4][at % 4] = cloud.sh_rest[i * rest + k][static_cast<int>(c)];
    }
}

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

Expected<void> check_size(const gl::Capabilities& driver, const SplatCloud& cloud) {
  const std::uint64_t most = most_splats(driver, cloud.sh_degree);
  if (cloud.size() <= most) return {};
  return fail("scene", "size",
              std::to_string(cloud.size()) + " splats of degree " +
                  std::to_string(cloud.sh_degree) + " are too many for " + driver.renderer +
                  ": it can hold " + std::to_string(most));
}

}  // namespace

PackedScene pack_scene(const SplatCloud& cloud) {
  std::vector<std::size_t> splats;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (drawable(cloud, i)) splats.push_back(i);

  PackedScene scene;
  scene.constants.count = static_cast<std::uint32_t>(cloud.size());
  scene.constants.sh_degree = cloud.sh_degree;
  scene.constants.origin = median_position(cloud, splats);
  scene.harmonics_stride = harmonics_stride(cloud.sh_degree);
  scene.geometry.assign(4 * cloud.size(), {0, 0, 0, static_cast<float>(kNoLevel)});
  scene.harmonics.resize(scene.harmonics_stride * cloud.size());
  scene.undrawable = cloud.size() - splats.size();
  for (const std::size_t i : splats) {
    pack_geometry(cloud, i, scene.constants.origin, &scene.geometry[4 * i]);
    pack_harmonics(cloud, i, scene.harmonics.data() + scene.harmonics_stride * i);
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

std::uint64_t most_splats(const gl::Capabilities& driver, int sh_degree) {
  const std::size_t per_splat =
      sizeof(float) * 4 * std::max<std::size_t>(4, harmonics_stride(sh_degree));
  const auto by_bytes = static_cast<std::uint64_t>(driver.max_storage_block_bytes) / per_splat;
  const auto by_groups = static_cast<std::uint64_t>(driver.max_work_groups_x) * 128 - 1;
  return std::min({by_bytes, by_groups, std::uint64_t{0xFFFF0000}});
}

Expected<void> check_scene(const gl::Capabilities& driver, const SplatCloud& cloud) {
  return gl::in_turn([&] { return check_cloud(cloud); }, [&] { return check_size(driver, cloud); });
}

Expected<SceneBuffers> SceneBuffers::create(gl::Api& api, const PackedScene& scene) {
  SceneBuffers buffers;
  buffers.constants = scene.constants;
  buffers.harmonics_stride = scene.harmonics_stride;
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
