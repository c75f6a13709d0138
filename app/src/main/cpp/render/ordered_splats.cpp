#include "render/ordered_splats.h"

#include <string>
#include <vector>

#include "gl/expected_chain.h"
#include "shaders/shaders.h"

namespace fluxgs::render {
namespace {

constexpr std::size_t kTexelBytes = 16;

/// Texels of so many projected splats.
std::uint64_t texels_of(std::uint64_t count, SplatPrecision precision) {
  return count * projected_splat_bytes(precision) / kTexelBytes;
}

}  // namespace

std::size_t ordered_splat_bytes(std::uint64_t count, SplatPrecision precision) {
  return gl::TexelArray::bytes(GL_RGBA32UI, texels_of(count, precision));
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
  texels_ = {};  // There may not be room for both
  return gl::assign_or_error(
      gl::TexelArray::create(api, GL_RGBA32UI, texels_of(entries, precision_)), texels_);
}

void OrderedSplats::update(gl::Api& api, const gl::Buffer& projected_splats,
                           const sort::Sorter& sorter, const gl::Buffer& arguments,
                           std::size_t dispatch_offset) const {
  sorter.count().bind_base(GL_SHADER_STORAGE_BUFFER, 0);
  sorter.order().bind_base(GL_SHADER_STORAGE_BUFFER, 1);
  projected_splats.bind_base(GL_SHADER_STORAGE_BUFFER, 2);
  api.BindImageTexture(0, texels_.texture().name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
  arguments.bind(GL_DISPATCH_INDIRECT_BUFFER);
  program_.use();
  api.DispatchComputeIndirect(static_cast<GLintptr>(dispatch_offset));
  api.MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
  texels_.bind(0);
}

}  // namespace fluxgs::render
