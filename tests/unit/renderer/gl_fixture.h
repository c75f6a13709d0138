// A context and a renderer for the tests, one of each per GL implementation and process.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include "platform/host/host_context.h"
#include "render/renderer.h"

namespace fluxgs::test {

/// The value; or a test failure with the error's text, and an exception that ends the test.
template <class T>
T must(Expected<T> value) {
  if (!value) throw std::runtime_error(value.error().message());
  if constexpr (!std::is_void_v<T>) return std::move(*value);
}

/// What is made once and used by all tests of one implementation.
struct Shared {
  Expected<std::unique_ptr<host::HostContext>> context;
  std::unique_ptr<render::Renderer> renderer;

  explicit Shared(host::HostGl gl) : context(host::HostContext::create(gl)) {}
  Shared(const Shared&) = delete;
  Shared& operator=(const Shared&) = delete;
  ~Shared() {
    if (context && (*context)->make_current()) renderer.reset();
  }
};

inline std::map<host::HostGl, Shared>& all_shared() {
  static std::map<host::HostGl, Shared> all;
  return all;
}
inline Shared& shared(host::HostGl gl) { return all_shared().try_emplace(gl, gl).first->second; }

/// Lets go of them before exit(): drivers clean up there before our static objects would.
class SharedEnd : public testing::Environment {
 public:
  void TearDown() override { all_shared().clear(); }
};
inline testing::Environment* const shared_end = testing::AddGlobalTestEnvironment(new SharedEnd);

/// Runs every test on each implementation, or skips it where the machine lacks the library. Any
/// complaint of the driver (KHR_debug) is a failure.
class GlTest : public testing::TestWithParam<host::HostGl> {
 protected:
  void SetUp() override {
    Shared& all = shared(GetParam());
    if (!all.context) GTEST_SKIP() << all.context.error().message();
    must((*all.context)->make_current());
    api().debug.messages.clear();
  }

  void TearDown() override {
    if (!shared(GetParam()).context) return;
    must(context().make_current());
    EXPECT_EQ(api().GetError(), GLenum{GL_NO_ERROR});
    for (const gl::DebugMessage& message : api().debug.mistakes())
      ADD_FAILURE() << "the driver complains: " << message.text;
  }

  host::HostContext& context() { return **shared(GetParam()).context; }
  gl::Api& api() { return context().api(); }

  /// With the default settings, and the stage times.
  render::Renderer& renderer() {
    auto& made = shared(GetParam()).renderer;
    if (!made) made = must(render::Renderer::create(api(), {.timestamps = true}));
    return *made;
  }
};

inline std::string implementation_name(const testing::TestParamInfo<host::HostGl>& info) {
  return std::string(host::name(info.param));
}

/// All of them; GlTest skips those that the machine lacks.
inline constexpr host::HostGl kImplementations[] = {host::HostGl::egl, host::HostGl::osmesa,
                                                    host::HostGl::angle};

}  // namespace fluxgs::test

#define FLUXGS_GL_TEST_SUITE(suite)                                                      \
  INSTANTIATE_TEST_SUITE_P(Gl, suite, testing::ValuesIn(fluxgs::test::kImplementations), \
                           fluxgs::test::implementation_name)
