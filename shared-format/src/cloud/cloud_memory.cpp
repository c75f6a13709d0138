#include "cloud/cloud_memory.h"

#include <exception>

#include <fmt/format.h>

#include "fluxgs/io/scene_file.h"

namespace fluxgs::io {
namespace {

// Runs `allocate`, which throws bad_alloc or, beyond what a vector can count, length_error.
template <class Allocate>
Expected<void> try_allocate(std::size_t bytes, const std::string& name, Allocate allocate) {
  try {
    allocate();
  } catch (const std::exception&) {
    return fail(name, "memory", fmt::format("out of memory: {} bytes wanted", bytes));
  }
  return {};
}

}  // namespace

Expected<SplatCloud> allocate_cloud(std::size_t count, int sh_degree, const std::string& name) {
  Expected<SplatCloud> cloud;
  cloud->sh_degree = sh_degree;
  const auto done =
      try_allocate(splat_memory_bytes(count, sh_degree), name, [&] { cloud->resize(count); });
  if (!done) cloud = std::unexpected(done.error());
  return cloud;
}

Expected<void> reserve_cloud(std::size_t count, const std::string& name, SplatCloud& cloud) {
  return try_allocate(splat_memory_bytes(count, cloud.sh_degree), name, [&] {
    cloud.positions.reserve(count);
    cloud.log_scales.reserve(count);
    cloud.rotations.reserve(count);
    cloud.opacity_logits.reserve(count);
    cloud.sh_dc.reserve(count);
    cloud.sh_rest.reserve(count * static_cast<std::size_t>(sh_rest_count(cloud.sh_degree)));
  });
}

Expected<std::vector<std::byte>> allocate_bytes(std::size_t size, const std::string& name) {
  Expected<std::vector<std::byte>> bytes;
  const auto done = try_allocate(size, name, [&] { bytes->resize(size); });
  if (!done) bytes = std::unexpected(done.error());
  return bytes;
}

Expected<const SplatCloud*> writable_cloud(const SplatCloud& cloud, SplatCloud& storage,
                                           const std::string& name) {
  const std::size_t n = cloud.size();
  if (cloud.sh_degree < 0 || cloud.sh_degree > 3) {
    return fail(name, "sh_degree", fmt::format("is {}; expected 0 to 3", cloud.sh_degree));
  }
  const std::size_t rest = n * static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  if (cloud.log_scales.size() != n || cloud.rotations.size() != n ||
      cloud.opacity_logits.size() != n || cloud.sh_dc.size() != n || cloud.sh_rest.size() != rest) {
    return fail(name, "scene", fmt::format("its arrays disagree about the {} splats", n));
  }
  const std::size_t bad = count_non_finite(cloud);
  if (bad == 0) return &cloud;
  const auto copied = try_allocate(splat_memory_bytes(n, cloud.sh_degree), name, [&] {
    storage = cloud;
    drop_non_finite(storage);
  });
  if (!copied) return std::unexpected(copied.error());
  return &storage;
}

}  // namespace fluxgs::io
