// Contexts without a window: made, switched and made again in one process.
#include "platform/host/host_context.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "gl/buffer.h"
#include "gl/program.h"
#include "gl_fixture.h"

namespace fluxgs::test {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

/// Sets a variable of the environment and puts back what it was.
class EnvironmentVariable {
 public:
  explicit EnvironmentVariable(const char* name) : name_(name) {
    if (const char* value = std::getenv(name)) before_ = value;
  }
  EnvironmentVariable(const EnvironmentVariable&) = delete;
  EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;
  ~EnvironmentVariable() { set(before_ ? before_->c_str() : nullptr); }

  /// Null: not set at all.
  void set(const char* value) const {
    if (value) {
      ::setenv(name_, value, 1);
    } else {
      ::unsetenv(name_);
    }
  }

 private:
  const char* name_;
  std::optional<std::string> before_;
};

TEST(HostGl, NamesAreReadBack) {
  for (const host::HostGl gl : {host::HostGl::egl, host::HostGl::osmesa, host::HostGl::angle})
    EXPECT_EQ(host::parse_host_gl(host::name(gl)), gl);
  const auto unknown = host::parse_host_gl("direct3d");
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message(), HasSubstr("egl, osmesa or angle"));
}

TEST(HostGl, TheVariableDecidesWhereAngleIs) {
  const EnvironmentVariable variable("FLUXGS_ANGLE_DIR");
  variable.set("/a folder/angle");
  EXPECT_EQ(host::angle_folder(), "/a folder/angle");
  for (const char* none : {"", static_cast<const char*>(nullptr)}) {
    variable.set(none);
    EXPECT_THAT(host::angle_folder(), EndsWith("/build/packages/angle"));
  }
}

// In a process of its own: the libraries are looked for once.
TEST(HostGlDeathTest, MissingAngleIsAnErrorThatSaysHowToGetIt) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto try_it = [] {
    const EnvironmentVariable variable("FLUXGS_ANGLE_DIR");
    variable.set("/nowhere");
    const auto context = host::HostContext::create(host::HostGl::angle);
    std::fputs(context ? "made" : context.error().message().c_str(), stderr);
    std::exit(0);
  };
  EXPECT_EXIT(try_it(), testing::ExitedWithCode(0),
              "/nowhere/libEGL.so: .*run tools/deps/angle, or .* FLUXGS_ANGLE_DIR");
}

class HostContextTest : public GlTest {};

TEST_P(HostContextTest, SaysWhatItIs) {
  EXPECT_FALSE(context().renderer_string().empty());
  EXPECT_EQ(api().capabilities.is_es, GetParam() != host::HostGl::osmesa);
  if (GetParam() == host::HostGl::angle) {  // Mesa may return a later version than was asked for
    EXPECT_EQ(api().capabilities.major, 3);
    EXPECT_EQ(api().capabilities.minor, 1);
  }
  EXPECT_TRUE(gl::check_limits(api().capabilities));
}

// Writes 42 on the GPU and reads it back.
void expect_working(host::HostContext& context) {
  must(context.make_current());
  constexpr std::string_view kSource =
      "#version 310 es\n"
      "layout(local_size_x = 1) in;\n"
      "layout(std430, binding = 0) buffer Out { uint value; };\n"
      "void main() { value = uint(ANSWER); }\n";
  const gl::ShaderSource source{GL_COMPUTE_SHADER, "answer", kSource};
  const std::array<std::string, 1> defines = {"ANSWER 42"};
  const gl::Program program = must(gl::Program::create(context.api(), {&source, 1}, defines));
  const gl::Buffer buffer = must(gl::Buffer::create(context.api(), 4));
  buffer.bind_base(GL_SHADER_STORAGE_BUFFER, 0);
  program.use();
  context.api().DispatchCompute(1, 1, 1);
  EXPECT_EQ(must(buffer.read_all<std::uint32_t>(1)).front(), 42U);
}

TEST_P(HostContextTest, CanBeMadeAgainAndAgain) {
  for (int i = 0; i < 3; ++i) {
    const auto fresh = must(host::HostContext::create(GetParam()));
    expect_working(*fresh);
  }
}

TEST_P(HostContextTest, SeveralLiveSideBySide) {
  std::vector<std::unique_ptr<host::HostContext>> contexts;
  contexts.push_back(must(host::HostContext::create(GetParam())));
  for (const host::HostGl other : kImplementations)
    if (auto made = host::HostContext::create(other)) contexts.push_back(std::move(*made));
  contexts.push_back(must(host::HostContext::create(GetParam())));
  for (int round = 0; round < 2; ++round)
    for (const auto& one : contexts) expect_working(*one);
}

TEST_P(HostContextTest, TheDriversComplaintsAreHeard) {
  if (!api().capabilities.debug) GTEST_SKIP() << "no KHR_debug";
  api().Enable(0xDEAD);
  EXPECT_NE(api().GetError(), GLenum{GL_NO_ERROR});
  EXPECT_FALSE(api().debug.mistakes().empty());
  api().debug.messages.clear();
}

TEST_P(HostContextTest, ABufferTooLargeIsAnError) {
  const auto buffer = gl::Buffer::create(api(), std::size_t{1} << 60U);
  ASSERT_FALSE(buffer);
  EXPECT_THAT(buffer.error().message(), HasSubstr("1152921504606846976 bytes"));
  api().debug.messages.clear();
}

FLUXGS_GL_TEST_SUITE(HostContextTest);

}  // namespace
}  // namespace fluxgs::test
