#include <cstring>

#include <fmt/format.h>

#include "cloud/cloud_memory.h"
#include "fluxgs/io/ply.h"
#include "io/ply/ply_filter.h"
#include "io/ply/ply_view.h"

namespace fluxgs {
namespace {

std::string header_of(const SplatCloud& cloud, const std::optional<InitialView>& start) {
  std::string text =
      fmt::format("ply\nformat binary_little_endian 1.0\n{}{}element vertex {}\n",
                  io::comment_lines(cloud.filter), io::comment_line(start), cloud.size());
  const auto property = [&](const char* stem) { text += fmt::format("property float {}\n", stem); };
  const auto numbered = [&](const char* stem, int count) {
    for (int i = 0; i < count; ++i) text += fmt::format("property float {}_{}\n", stem, i);
  };
  for (const char* plain : {"x", "y", "z", "nx", "ny", "nz"}) property(plain);
  numbered("f_dc", 3);
  numbered("f_rest", 3 * sh_rest_count(cloud.sh_degree));
  property("opacity");
  numbered("scale", 3);
  numbered("rot", 4);
  return text + "end_header\n";
}

// One row in the order of the header; returns how many floats it has.
std::size_t fill_row(const SplatCloud& cloud, std::size_t i, float* row) {
  float* out = row;
  const auto put = [&](const glm::vec3& v) {
    for (int c = 0; c < 3; ++c) *out++ = v[c];
  };
  put(cloud.positions[i]);
  put(glm::vec3(0));  // normals: unused, but expected by other readers
  put(cloud.sh_dc[i]);
  const auto rest = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  for (int c = 0; c < 3; ++c) {  // channel-major
    for (std::size_t k = 0; k < rest; ++k) *out++ = cloud.sh_rest[i * rest + k][c];
  }
  *out++ = cloud.opacity_logits[i];
  put(cloud.log_scales[i]);
  const glm::quat& q = cloud.rotations[i];
  for (const float c : {q.w, q.x, q.y, q.z}) *out++ = c;
  return static_cast<std::size_t>(out - row);
}

}  // namespace

Expected<std::vector<std::byte>> encode_ply(const SplatCloud& cloud, const std::string& name,
                                            const std::optional<InitialView>& start) {
  SplatCloud storage;
  const auto finite = io::writable_cloud(cloud, storage, name);
  if (!finite) return std::unexpected(finite.error());
  const SplatCloud& splats = **finite;
  const std::string header = header_of(splats, start);
  const std::size_t floats = 17 + 3 * static_cast<std::size_t>(sh_rest_count(splats.sh_degree));
  auto bytes = io::allocate_bytes(header.size() + splats.size() * floats * sizeof(float), name);
  if (!bytes) return bytes;
  std::memcpy(bytes->data(), header.data(), header.size());
  std::byte* out = bytes->data() + header.size();
  float row[62];
  for (std::size_t i = 0; i < splats.size(); ++i) {
    const std::size_t size = fill_row(splats, i, row) * sizeof(float);
    std::memcpy(out, row, size);
    out += size;
  }
  return bytes;
}

}  // namespace fluxgs
