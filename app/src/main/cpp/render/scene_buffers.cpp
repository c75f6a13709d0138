#include "render/scene_buffers.h"

#include <algorithm>
#include <span>
#include <string>

#include "gl/expected_chain.h"
#include "render/fragment_pipeline.h"

namespace fluxgs::render {
namespace {

constexpr std::uint64_t kWordBytes = sizeof(PackedSplats::sh[0]);
constexpr std::uint64_t kMaxSh = kWordBytes << 30;  // what sh_word() can point into

/// Splats of a part of a scene, after those that are there.
class Writer {
 public:
  explicit Writer(gl::Buffer& buffer) : buffer_(buffer) {}
  template <class T>
  void add(const std::vector<T>& values) {
    const auto bytes = std::as_bytes(std::span(values));
    if (!bytes.empty()) buffer_.write(written_, bytes);
    written_ += bytes.size();
  }

 private:
  gl::Buffer& buffer_;
  std::size_t written_ = 0;
};

}  // namespace

Expected<void> check_cloud(const RenderCloud& cloud) {
  if (cloud.sh_degree < 0 || cloud.sh_degree > 3) {
    return fail("scene", "sh_degree",
                std::to_string(cloud.sh_degree) + "; 0, 1, 2 or 3 was expected");
  }
  const std::size_t n = cloud.size();
  const bool complete = cloud.base.log_scales.size() == n && cloud.base.rotations.size() == n &&
                        cloud.base.opacity_logits.size() == n && cloud.base.sh_dc.size() == n &&
                        cloud.sh.size() == n * cloud.sh_size();
  if (complete) return {};
  return fail("scene", "attributes", "every splat must have all of them");
}

std::uint64_t max_splats(const gl::Capabilities& driver, const DegreeCounts& scene) {
  if (!driver.compute) return FragmentPipeline::max_splats(driver, scene);
  const auto block = static_cast<std::uint64_t>(driver.max_storage_block_bytes);
  const auto by_groups = static_cast<std::uint64_t>(driver.max_work_groups_x) * 128 - 1;
  return std::min({block / kGeometryBytes, by_groups, std::uint64_t{0xFFFF0000},
                   with_sh_in(std::min(block, kMaxSh), scene)});
}

Expected<void> check_size(const gl::Capabilities& driver, const DegreeCounts& scene) {
  const std::uint64_t most = max_splats(driver, scene);
  const std::uint64_t count = count_of(scene);
  if (count <= most) return {};
  return fail("scene", "size",
              std::to_string(count) + " splats are too many for " + driver.renderer +
                  ": it can hold " + std::to_string(most));
}

Expected<SceneBuffers> SceneBuffers::create(gl::Api& api, ScenePacker& packer,
                                            std::vector<glm::vec3>* positions) {
  SceneBuffers buffers;
  buffers.count = packer.constants().count;
  const auto make = [&](std::uint64_t bytes, gl::Buffer& buffer) {
    return buffer.remake(api, bytes, nullptr, GL_STATIC_DRAW);
  };
  auto made = gl::chain([&] { return make(kGeometryBytes * buffers.count, buffers.geometry); },
                        [&] { return make(sh_bytes(packer.degrees()), buffers.sh); });
  if (!made) return std::unexpected(made.error());
  Writer geometry(buffers.geometry), sh(buffers.sh);
  pack_in_parts(packer, positions, [&](const PackedSplats& part) {
    geometry.add(part.geometry);
    sh.add(part.sh);
  });
  return buffers;
}

}  // namespace fluxgs::render
