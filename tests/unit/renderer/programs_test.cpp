// The list of programs (shaders/programs.cmake) is what the renderer really makes: what compilers
// other than this machine's driver are shown is then neither too little nor stale.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <utility>

#include "fluxgs/io/file.h"
#include "gl_fixture.h"
#include "render/blend_check.h"
#include "scenes.h"

namespace fluxgs::test {
namespace {

/// Settings that together make every program. The size of a batch stays at its default, as in the
/// list.
std::vector<render::RendererSettings> all_settings() {
  using enum render::SplatPrecision;
  // Does not compile when a setting is added: does it change a shader? Then it has to vary below.
  [[maybe_unused]] const auto& [sorter, splat_precision, batch, sort_digit_bits, timestamps,
                                compute, project_in_vertices, texture_fetch, slices,
                                background_sort, approximation] = render::RendererSettings{};
  std::vector<render::RendererSettings> all;
  for (int bits = 4; bits <= 8; ++bits) all.push_back({.sort_digit_bits = bits});
  for (const auto precision : {full, half})
    for (const bool texture : {false, true})
      all.push_back({.splat_precision = precision, .texture_fetch = texture});
  for (const auto precision : {full, half})
    all.push_back({.splat_precision = precision, .slices = 2});
  for (const auto kind : {render::SorterKind::cpu_async, render::SorterKind::exact})
    all.push_back({.sorter = kind});
  for (const auto precision : {full, half})
    for (const bool in_vertices : {false, true})
      all.push_back(
          {.splat_precision = precision, .compute = false, .project_in_vertices = in_vertices});
  return all;
}

std::set<std::string>* recorded = nullptr;
decltype(gl::Api::ShaderSource) hand_to_driver = nullptr;

void GL_APIENTRY record(GLuint shader, GLsizei count, const GLchar* const* text,
                        const GLint* lengths) {
  recorded->insert(std::string(*text));  // Program::create passes one text that ends with a zero
  hand_to_driver(shader, count, text, lengths);
}

std::set<std::string> listed() {
  std::set<std::string> texts;
  for (const auto& entry : std::filesystem::directory_iterator(FLUXGS_PROGRAMS_FOLDER)) {
    const auto bytes = must(read_file(entry.path()));
    texts.emplace(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  return texts;
}

class ProgramsTest : public GlTest {
 protected:
  void make_all() {
    static_cast<void>(must(render::half_float_blending_truncates(api())));
    for (const render::RendererSettings& settings : all_settings())
      for (const bool compensated : {false, true}) {
        const auto renderer = must(render::Renderer::create(api(), settings));
        const auto target =
            must(render::RenderTarget::create(api(), 4, 4, render::TargetFormat::rgba8));
        must(renderer->draw(front_camera(4, 4, 1),
                            {.filter = ScreenFilter{.compensated = compensated}}, target));
      }
  }
};

TEST_P(ProgramsTest, AreThoseOfTheList) {
  std::set<std::string> made;
  recorded = &made;
  hand_to_driver = api().ShaderSource;
  api().ShaderSource = record;
  make_all();
  const bool compute = std::exchange(api().capabilities.compute, false);
  make_all();  // the same shaders as of ES 3.0
  api().capabilities.compute = compute;
  api().ShaderSource = hand_to_driver;

  const std::set<std::string> list = listed();
  ASSERT_FALSE(list.empty());
  for (const std::string& text : made)
    EXPECT_TRUE(list.contains(text)) << "not in shaders/programs.cmake:\n" << text;
  for (const std::string& text : list) {
    const bool of_slices = text.contains("#define FRONT_TO_BACK\n") ||
                           text.contains("#define MARK\n") ||
                           text.contains("GL_EXT_shader_framebuffer_fetch");
    if (of_slices && !api().capabilities.framebuffer_fetch) continue;
    EXPECT_TRUE(made.contains(text)) << "in shaders/programs.cmake, but nobody makes it:\n" << text;
  }
}

FLUXGS_GL_TEST_SUITE(ProgramsTest);

}  // namespace
}  // namespace fluxgs::test
