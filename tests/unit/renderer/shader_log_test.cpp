// Where an error in a shader is: in which file of shaders/, in which stage and line, whatever the
// driver and however many files were put together.
#include "gl/shader_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "fluxgs/io/file.h"
#include "gl/program.h"
#include "gl_fixture.h"
#include "shaders/shaders.h"

namespace fluxgs::test {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr std::string_view kText =
    "#version 310 es\n"
    "// line 1001 is line 1 of frame.glsl\n#line 1001\nfirst\n#line 3\n"
    "// line 12001 is line 1 of projected_splat.glsl\n#line 12001\nsecond\n#line 4\n";

std::string named(std::string_view log) { return gl::name_lines(log, "splat.vert", kText); }

TEST(NameLines, InTheWordsOfEveryDriver) {
  EXPECT_EQ(named("0:7(5): error: `x' undeclared"), "splat.vert:7(5): error: `x' undeclared");
  EXPECT_EQ(named("ERROR: 0:1003: 'x' : undeclared"), "ERROR: frame.glsl:3: 'x' : undeclared");
  EXPECT_EQ(named("WARNING: 0:1003: unused"), "WARNING: frame.glsl:3: unused");
  EXPECT_EQ(named("0:12034: L0002: Undeclared variable"),
            "projected_splat.glsl:34: L0002: Undeclared variable");
  EXPECT_EQ(named("0(12034) : error C1503: undefined"),
            "projected_splat.glsl:34 : error C1503: undefined");
  EXPECT_EQ(named("0:999(1): error: a\n0:1001(3): error: b\n"),
            "splat.vert:999(1): error: a\nframe.glsl:1(3): error: b\n");
}

TEST(NameLines, LeavesEverythingElse) {
  for (const char* text : {"", "\n", "0", "0:", "1(", "0:x", ":3", "-1:3", "0:-3: x",
                           "0:2003: no such file", "3 errors.", "ERROR: ", "error in 0:3",
                           "0:99999999999999999999: x", "99999999999999999999:1: x"})
    EXPECT_EQ(named(text), text);
}

struct Fault {
  const char* name;  ///< of the shader
  GLenum stage;
  const char* stage_name;
  std::string_view text;  ///< of the shader
  const char* file;       ///< where the fault is made
  const char* statement;  ///< before which; it is there once
};

// After an included file, in one, and in one that is left out by the preprocessor up to there.
const Fault kFaults[] = {
    {"splat.vert", GL_VERTEX_SHADER, "vertex", shaders::splat_vert, "splat.vert",
     "  ProjectedSplat r = read_projected_splat("},
    {"splat.vert", GL_VERTEX_SHADER, "vertex", shaders::splat_vert, "projected_splat.glsl",
     "  vec4 head = uintBitsToFloat("},
    {"splat.frag", GL_FRAGMENT_SHADER, "fragment", shaders::splat_frag, "splat.frag",
     "  float level = v_shape.w"},
    {"project.comp", GL_COMPUTE_SHADER, "compute", shaders::project_comp,
     "spherical_harmonics.glsl", "  float xx = x * x"},
    {"project.comp", GL_COMPUTE_SHADER, "compute", shaders::project_comp, "project.comp",
     "  uint splat = gl_GlobalInvocationID.x;"},
};

std::string line_of(const Fault& fault) {
  const std::string path = std::string(FLUXGS_SHADERS_FOLDER) + "/" + fault.file;
  const auto bytes = must(read_file(path));
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t at = text.find(fault.statement);
  EXPECT_NE(at, text.npos) << fault.statement;
  return std::to_string(1 + std::ranges::count(text.substr(0, at), '\n'));
}

class ShaderLogTest : public GlTest {};

TEST_P(ShaderLogTest, ErrorsNameFileStageAndLine) {
  const std::array<std::string, 2> defines = {"BATCH 128", "SOMETHING_ELSE"};
  for (const Fault& fault : kFaults) {
    std::string text(fault.text);
    const std::size_t at = text.find(fault.statement);
    ASSERT_NE(at, text.npos);
    text.insert(at, "  no_such_thing = 1; ");
    const gl::ShaderSource source{fault.stage, fault.name, text};
    const auto program = gl::Program::create(api(), {&source, 1}, defines);
    api().debug.messages.clear();  // The mistake was meant
    ASSERT_FALSE(program);
    const std::string message = program.error().message();
    const std::string shader = std::string(fault.stage_name) + " shader " + fault.name + ": ";
    EXPECT_THAT(message, HasSubstr(shader));
    EXPECT_THAT(message, HasSubstr(std::string(fault.file) + ":" + line_of(fault)));
    EXPECT_THAT(message, HasSubstr("no_such_thing"));
    EXPECT_THAT(message, Not(HasSubstr("\n")));
  }
}

FLUXGS_GL_TEST_SUITE(ShaderLogTest);

}  // namespace
}  // namespace fluxgs::test
