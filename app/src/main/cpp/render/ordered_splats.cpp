#include "render/ordered_splats.h"

#include <algorithm>
#include <string>
#include <vector>

#include "gl/expected_chain.h"
#include "shaders/shaders.h"

namespace fluxgs::render {
namespace {

constexpr std::size_t kTextureWidth = 2048, kTexelBytes = 16;  // shaders/ordered_splats.glsl

std::size_t texture_rows(std::uint64_t count, SplatPrecision precision) {
  const std::size_t texels = count * projected_splat_bytes(precision) / kTexelBytes;
  return std::max<std::size_t>((texels + kTextureWidth - 1) / kTextureWidth, 1);
}

}  // namespace

std::size_t ordered_splat_bytes(std::uint64_t count, SplatPrecision precision) {
  return texture_rows(count, precision) * kTextureWidth * kTexelBytes;
}

Expected<OrderedSplats> OrderedSplats::create(gl::Api& api, int batch, SplatPrecision precision) {
  OrderedSplats made;
  made.precision_ = precision;
  const gl::ShaderSource source{GL_COMPUTE_SHADER, "gather.comp", shaders::gather_comp};
  std::vector<std::string> defines = {"BATCH " + std::to_string(batch)};
  if (precision == SplatPrecision::half) defines.emplace_back("PROJECTED_SPLAT_HALF");
  auto compiled =
      gl::assign_or_error(gl::Program::create(api, {&source, 1}, defines), made.program_);
  if (!compiled) return std::unexpected(compiled.error());
  return made;
}

Expected<void> OrderedSplats::reserve(gl::Api& api, std::uint64_t entries) {
  texture_ = {};  // There may not be room for both
  const auto rows = static_cast<int>(texture_rows(entries, precision_));
  if (rows > api.capabilities.max_texture_size) {
    return fail("scene", "size",
                "its projected splats need a texture of " + std::to_string(rows) + " rows; " +
                    api.capabilities.renderer + " offers " +
                    std::to_string(api.capabilities.max_texture_size));
  }
  return gl::assign_or_error(
      gl::Texture::create(api, GL_RGBA32UI, static_cast<int>(kTextureWidth), rows), texture_);
}

void OrderedSplats::update(gl::Api& api, const gl::Buffer& projected_splats,
                           const sort::Sorter& sorter, const gl::Buffer& arguments,
                           std::size_t dispatch_offset) const {
  sorter.count().bind_base(GL_SHADER_STORAGE_BUFFER, 0);
  sorter.order().bind_base(GL_SHADER_STORAGE_BUFFER, 1);
  projected_splats.bind_base(GL_SHADER_STORAGE_BUFFER, 2);
  api.BindImageTexture(0, texture_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
  arguments.bind(GL_DISPATCH_INDIRECT_BUFFER);
  program_.use();
  api.DispatchComputeIndirect(static_cast<GLintptr>(dispatch_offset));
  api.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
  texture_.bind(0);
}

}  // namespace fluxgs::render
