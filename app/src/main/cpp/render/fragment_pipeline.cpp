#include "render/fragment_pipeline.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "gl/expected_chain.h"
#include "render/draw_pass.h"
#include "render/quad_indices.h"
#include "shaders/shaders.h"

namespace fluxgs::render {
namespace {

// Texture units; the order's is that which TexelArray::write() uses as well.
constexpr GLint kGeometry = 0, kCoefficients = 1;
constexpr GLint kOrder = 0, kFirstWords = 1, kSecondWords = 2;

constexpr std::uint64_t kTexelsOfASplat = 4;  // of the geometry
constexpr std::uint64_t kWordBytes = sizeof(PackedSplats::sh[0]);

/// Parts of an array, one after the other.
class TexelWriter {
 public:
  TexelWriter(gl::Api& api, const gl::TexelArray& array) : api_(api), array_(array) {}
  template <class T>
  void add(const std::vector<T>& texels) {
    array_.write(api_, written_, std::as_bytes(std::span(texels)));
    written_ += texels.size();
  }

 private:
  gl::Api& api_;
  const gl::TexelArray& array_;
  std::uint64_t written_ = 0;
};

std::uint64_t words_of(const DegreeCounts& splats) { return sh_bytes(splats) / kWordBytes; }

}  // namespace

Expected<std::unique_ptr<SplatPipeline>> FragmentPipeline::create(
    gl::Api& api, const RendererSettings& settings) {
  std::unique_ptr<FragmentPipeline> made(new FragmentPipeline(api, settings));
  auto done = gl::chain(
      [&] { return gl::assign_or_error(made->compile_projection(false), made->projection_); },
      [&] { return gl::assign_or_error(made->compile_draw(), made->draw_); },
      [&] {
        return gl::assign_or_error(create_quad_indices(api, settings.batch), made->indices_);
      });
  if (!done) return std::unexpected(done.error());
  made->drawn_ = made->draw_.uniform("drawn");
  made->vertex_array_ = gl::VertexArray(api);
  return made;
}

Expected<FragmentPipeline::Projection> FragmentPipeline::compile_projection(
    bool compensated) const {
  constexpr GLenum kVertex = GL_VERTEX_SHADER, kFragment = GL_FRAGMENT_SHADER;
  const std::array<gl::ShaderSource, 2> fragments = {
      {{kVertex, "screen.vert", shaders::screen_vert},
       {kFragment, "project.frag", shaders::project_frag}}};
  const std::array<gl::ShaderSource, 2> points = {
      {{kVertex, "project_point.vert", shaders::project_point_vert},
       {kFragment, "project_point.frag", shaders::project_point_frag}}};
  std::vector<std::string> defines;
  if (!full()) defines.emplace_back("PROJECTED_SPLAT_HALF");
  if (compensated) defines.emplace_back("COMPENSATED");
  auto program = gl::Program::create(api_, in_vertices_ ? points : fragments, defines);
  if (!program) return std::unexpected(program.error());
  program->set_sampler("geometry", kGeometry);
  program->set_sampler("coefficients", kCoefficients);
  const GLint rows = in_vertices_ ? program->uniform("rows") : -1;
  return Projection{std::move(*program), rows};
}

Expected<gl::Program> FragmentPipeline::compile_draw() const {
  const std::array<gl::ShaderSource, 2> stages = {
      {{GL_VERTEX_SHADER, "splat.vert", shaders::splat_vert},
       {GL_FRAGMENT_SHADER, "splat.frag", shaders::splat_frag}}};
  std::vector<std::string> defines = {"BATCH " + std::to_string(batch_)};
  if (!full()) defines.emplace_back("PROJECTED_SPLAT_HALF");
  defines.emplace_back("PROJECTED_BY_FRAGMENTS");
  auto program = gl::Program::create(api_, stages, defines);
  if (!program) return program;
  program->set_sampler("order", kOrder);
  program->set_sampler("first_words", kFirstWords);
  if (full()) program->set_sampler("second_words", kSecondWords);
  return program;
}

std::uint64_t FragmentPipeline::scene_bytes(const DegreeCounts& splats) {
  return gl::TexelArray::bytes(GL_RGBA32UI, kTexelsOfASplat * count_of(splats)) +
         gl::TexelArray::bytes(GL_RG32UI, words_of(splats));
}

std::uint64_t FragmentPipeline::projected_bytes(std::uint64_t count, SplatPrecision precision) {
  const std::uint64_t textures = precision == SplatPrecision::full ? 2 : 1;
  return textures * gl::TexelArray::bytes(GL_RGBA32UI, count + 1);
}

std::uint64_t FragmentPipeline::max_splats(const gl::Capabilities& driver,
                                           const DegreeCounts& scene) {
  const std::uint64_t texels = gl::TexelArray::most_entries(driver);
  return std::min(texels / kTexelsOfASplat, with_sh_in(texels * kWordBytes, scene));
}

void FragmentPipeline::unload() {
  for (gl::TexelArray* array : {&geometry_, &coefficients_, &first_, &second_}) *array = {};
  projected_ = {};
}

Expected<void> FragmentPipeline::load(ScenePacker& packer, std::vector<glm::vec3>* positions) {
  return gl::chain([&] { return load_scene(packer, positions); },
                   [&] { return make_room(packer.constants().count); });
}

Expected<void> FragmentPipeline::load_scene(ScenePacker& packer,
                                            std::vector<glm::vec3>* positions) {
  const std::size_t count = packer.constants().count;
  auto made = gl::chain(
      [&] {
        return gl::assign_or_error(
            gl::TexelArray::create(api_, GL_RGBA32UI, kTexelsOfASplat * count), geometry_);
      },
      [&] {
        return gl::assign_or_error(
            gl::TexelArray::create(api_, GL_RG32UI, words_of(packer.degrees())), coefficients_);
      });
  if (!made) return made;
  TexelWriter geometry(api_, geometry_), coefficients(api_, coefficients_);
  pack_in_parts(packer, positions, [&](const PackedSplats& part) {
    geometry.add(part.geometry);
    coefficients.add(part.sh);
  });
  return {};
}

Expected<void> FragmentPipeline::make_room(std::uint64_t count) {
  count_ = static_cast<std::uint32_t>(count);
  auto made = gl::assign_or_error(gl::TexelArray::create(api_, GL_RGBA32UI, count + 1), first_);
  if (made && full())
    made = gl::assign_or_error(gl::TexelArray::create(api_, GL_RGBA32UI, count + 1), second_);
  if (!made) return made;
  std::vector<const gl::Texture*> words = {&first_.texture()};
  if (full()) words.push_back(&second_.texture());
  return gl::assign_or_error(gl::Framebuffer::create(api_, words), projected_);
}

Expected<void> FragmentPipeline::prepare(bool compensated) {
  if (!compensated || compensated_) return {};
  return gl::assign_or_error(compile_projection(true), compensated_);
}

void FragmentPipeline::project(bool compensated) {
  projected_.bind();
  constexpr std::array<GLenum, 2> kAll = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  api_.InvalidateFramebuffer(GL_FRAMEBUFFER, full() ? 2 : 1, kAll.data());  // written all over
  api_.Viewport(0, 0, gl::TexelArray::kWidth, first_.rows());
  geometry_.bind(kGeometry);
  coefficients_.bind(kCoefficients);
  const Projection& projection = compensated ? *compensated_ : projection_;
  projection.program.use();
  vertex_array_.bind();
  if (in_vertices_) {
    api_.Uniform1f(projection.rows, static_cast<float>(first_.rows()));
    api_.DrawArrays(GL_POINTS, 0, static_cast<GLsizei>(count_ + 1));
  } else {
    api_.DrawArrays(GL_TRIANGLES, 0, 3);
  }
  api_.BindVertexArray(0);
}

Expected<std::vector<std::uint32_t>> FragmentPipeline::read_projected(std::uint32_t count) const {
  constexpr std::size_t kWords = 4;  // of a texel
  const std::size_t textures = full() ? 2 : 1, width = gl::TexelArray::kWidth;
  const std::size_t rows = (count + width - 1) / width;
  std::vector<std::uint32_t> texture(kWords * width * rows), words(kWords * textures * count);
  projected_.bind();
  for (std::size_t t = 0; t < textures; ++t) {
    api_.ReadBuffer(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(t));
    api_.ReadPixels(0, 0, gl::TexelArray::kWidth, static_cast<GLsizei>(rows), GL_RGBA_INTEGER,
                    GL_UNSIGNED_INT, texture.data());
    for (std::size_t i = 0; i < count; ++i)
      std::copy_n(&texture[kWords * i], kWords, &words[kWords * (textures * i + t)]);
  }
  if (auto ok = gl::check_errors(api_, "reading projected splats"); !ok)
    return std::unexpected(ok.error());
  return words;
}

void FragmentPipeline::draw(const sort::Sorter& sorter, const glm::dvec3& background,
                            const RenderTarget& target) {
  clear(api_, background, target);
  const sort::OrderTexture& order = *sorter.order_texture();
  if (order.count == 0) return;
  api_.Viewport(0, 0, target.blend_width(), target.blend_height());
  order.indices.bind(kOrder);
  first_.bind(kFirstWords);
  if (full()) second_.bind(kSecondWords);
  draw_.use();
  api_.Uniform1ui(drawn_, order.count);
  vertex_array_.bind();
  indices_.bind(GL_ELEMENT_ARRAY_BUFFER);
  api_.Enable(GL_BLEND);
  api_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  const auto batch = static_cast<std::uint32_t>(batch_);
  const std::uint32_t instances = order.count / batch + (order.count % batch == 0 ? 0 : 1);
  api_.DrawElementsInstanced(GL_TRIANGLES, kIndicesOfAQuad * batch_, GL_UNSIGNED_SHORT, nullptr,
                             static_cast<GLsizei>(instances));
  api_.Disable(GL_BLEND);
  api_.BindVertexArray(0);
}

}  // namespace fluxgs::render
