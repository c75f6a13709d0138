#include "sort/gpu_radix_sorter.h"

#include <algorithm>
#include <string>

#include "gl/expected_chain.h"
#include "shaders/shaders.h"

namespace fluxgs::sort {
namespace {

// The twins of the constants in shaders/sort.glsl.
constexpr std::uint32_t kBlock = 2048;
constexpr std::uint32_t kDigitsPerGroup = 16;  // shaders/sort_scan.comp
constexpr GLintptr kDispatchOffset = 4;        // State::blocks
constexpr GLint kShift = 0, kKeyCount = 1;

std::uint32_t block_count(std::uint32_t keys) { return (keys + kBlock - 1) / kBlock; }

}  // namespace

Expected<std::unique_ptr<GpuRadixSorter>> GpuRadixSorter::create(gl::Api& api, int digit_bits) {
  if (digit_bits < 4 || digit_bits > 8) {
    return fail("sorter", "digit_bits", std::to_string(digit_bits) + "; 4 to 8 were expected");
  }
  std::unique_ptr<GpuRadixSorter> sorter(new GpuRadixSorter(api, digit_bits));
  if (auto ok = sorter->compile(); !ok) return std::unexpected(ok.error());
  if (auto ok = sorter->set_scene(0, 0, {}); !ok) return std::unexpected(ok.error());
  return sorter;
}

Expected<void> GpuRadixSorter::compile() {
  const auto make = [&](gl::Program& program, const char* name, std::string_view text,
                        const char* pass) -> Expected<void> {
    std::vector<std::string> defines = {"RADIX_BITS " + std::to_string(digit_bits_)};
    if (*pass) defines.emplace_back(pass);
    const gl::ShaderSource source{GL_COMPUTE_SHADER, name, text};
    return gl::assign_or_error(gl::Program::create(api_, {&source, 1}, defines), program);
  };
  const auto make_step = [&](Step& step, const char* name, std::string_view text) {
    return gl::chain([&] { return make(step.first, name, text, "FIRST_PASS"); },
                     [&] { return make(step.later, name, text, ""); });
  };
  const auto scatter = shaders::sort_scatter_comp;
  return gl::chain([&] { return make_step(digits_, "sort_count.comp", shaders::sort_count_comp); },
                   [&] { return make_step(scan_, "sort_scan.comp", shaders::sort_scan_comp); },
                   [&] { return make_step(scatter_, "sort_scatter.comp", scatter); },
                   [&] { return make(scatter_last_, "sort_scatter.comp", scatter, "LAST_PASS"); });
}

Expected<void> GpuRadixSorter::set_scene(std::uint32_t count, std::uint32_t spare,
                                         std::vector<glm::vec3> /*positions*/) {
  count_ = count;
  const std::size_t radix = std::size_t{1} << digit_bits_;
  const std::size_t blocks = std::max(block_count(count), 1U);
  const auto make = [&](gl::Buffer& buffer, std::size_t words) {
    return buffer.remake(api_, 4 * words);
  };
  return gl::chain([&] { return make(state_, 4 + radix + radix * blocks); },
                   [&] { return make(pairs_[0], std::size_t{2} * count); },
                   [&] { return make(pairs_[1], std::size_t{2} * count); },
                   [&] { return make(order_, std::size_t{count} + spare); });
}

void GpuRadixSorter::first_pass(const gl::Buffer& keys, std::uint32_t count) {
  const GLuint blocks = std::max(block_count(count), 1U);
  keys.bind_base(GL_SHADER_STORAGE_BUFFER, 1);
  pairs_[0].bind_base(GL_SHADER_STORAGE_BUFFER, 2);
  const auto step = [&](const gl::Program& program, GLuint groups) {
    program.use();
    api_.Uniform1ui(kKeyCount, count);  // The shift is 0, a uniform's initial value
    api_.DispatchCompute(groups, 1, 1);
    api_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  };
  step(digits_.first, blocks);
  step(scan_.first, (1U << digit_bits_) / kDigitsPerGroup);
  step(scatter_.first, blocks);
  api_.MemoryBarrier(GL_COMMAND_BARRIER_BIT);
}

void GpuRadixSorter::later_pass(int pass, bool last) {
  pairs_[(pass + 1) % 2].bind_base(GL_SHADER_STORAGE_BUFFER, 1);
  (last ? order_ : pairs_[pass % 2]).bind_base(GL_SHADER_STORAGE_BUFFER, 2);
  const auto shift = static_cast<GLuint>(pass * digit_bits_);
  const auto per_block = [&](const gl::Program& program) {
    program.use();
    api_.Uniform1ui(kShift, shift);
    api_.DispatchComputeIndirect(kDispatchOffset);
    api_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  };
  per_block(digits_.later);
  scan_.later.use();
  api_.DispatchCompute((1U << digit_bits_) / kDigitsPerGroup, 1, 1);
  api_.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  per_block(last ? scatter_last_ : scatter_.later);
}

void GpuRadixSorter::sort(const SortView& view, const gl::Buffer* keys) {
  sort_keys(*keys, count_, view.keys.bits);
}

void GpuRadixSorter::sort_keys(const gl::Buffer& keys, std::uint32_t count, int key_bits) {
  state_.bind_base(GL_SHADER_STORAGE_BUFFER, 0);
  state_.bind(GL_DISPATCH_INDIRECT_BUFFER);
  first_pass(keys, count);
  const int passes = std::max(2, (key_bits + digit_bits_ - 1) / digit_bits_);
  for (int pass = 1; pass < passes; ++pass) later_pass(pass, pass + 1 == passes);
}

}  // namespace fluxgs::sort
