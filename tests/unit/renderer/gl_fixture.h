// A context and a renderer for the tests, one of each per GL implementation and process.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "platform/host/host_context.h"
#include "render/gl_device.h"
#include "render/renderer.h"

namespace fluxgs::test {

/// The value; or a test failure with the error's text, and an exception that ends the test.
template <class T>
T must(Expected<T> value) {
  if (!value) throw std::runtime_error(value.error().message());
  if constexpr (!std::is_void_v<T>) return std::move(*value);
}

/// Where splats are projected.
enum class Stage { compute, fragments, vertices };

/// An OpenGL, and what of it the renderer uses.
struct GlForm {
  host::HostGl gl;
  Stage stage = Stage::compute;  ///< otherwise as if the driver had no compute shaders

  constexpr GlForm(host::HostGl implementation,  // NOLINT: stands for it
                   Stage projects_in = Stage::compute)
      : gl(implementation), stage(projects_in) {}
  bool has_compute() const { return stage == Stage::compute; }
  operator host::HostGl() const { return gl; }  // NOLINT
};

/// What is made once and used by all tests of one implementation.
struct Shared {
  Expected<std::unique_ptr<host::HostContext>> context;
  std::map<Stage, std::unique_ptr<render::Renderer>> renderers;

  explicit Shared(host::HostGl gl) : context(host::HostContext::create(gl)) {}
  Shared(const Shared&) = delete;
  Shared& operator=(const Shared&) = delete;
  ~Shared() {
    if (!context || !(*context)->make_current()) return;
    renderers.clear();
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
class GlTest : public testing::TestWithParam<GlForm> {
 protected:
  void SetUp() override {
    Shared& all = shared(GetParam());
    if (!all.context) GTEST_SKIP() << all.context.error().message();
    must((*all.context)->make_current());
    api().debug.messages.clear();
    has_compute_ = api().capabilities.compute;
    if (!GetParam().has_compute()) api().capabilities.compute = false;
    api().quirks.fragment_projection_fails = GetParam().stage == Stage::vertices;
  }

  void TearDown() override {
    if (!shared(GetParam()).context) return;
    must(context().make_current());
    api().capabilities.compute = has_compute_;
    api().quirks.fragment_projection_fails = false;
    EXPECT_EQ(api().GetError(), GLenum{GL_NO_ERROR});
    for (const gl::DebugMessage& message : api().debug.mistakes())
      ADD_FAILURE() << "the driver complains: " << message.text;
  }

  host::HostContext& context() { return **shared(GetParam()).context; }
  gl::Api& api() { return context().api(); }
  render::GlDevice& device() { return device_ ? *device_ : device_.emplace(api()); }

  /// With the default settings, and the stage times.
  render::Renderer& renderer() {
    auto& made = shared(GetParam()).renderers[GetParam().stage];
    if (!made) made = must(render::Renderer::create(api(), {.timestamps = true}));
    return *made;
  }

 private:
  std::optional<render::GlDevice> device_;
  bool has_compute_ = true;
};

inline std::string name_of(host::HostGl gl) { return std::string(host::name(gl)); }
inline std::string name_of(const GlForm& form) {
  if (form.stage == Stage::vertices) return name_of(form.gl) + "_in_vertices";
  return name_of(form.gl) + (form.has_compute() ? "" : "_without_compute");
}

inline void PrintTo(const GlForm& form, std::ostream* out) { *out << name_of(form); }

template <class Parameter>
std::string implementation_name(const testing::TestParamInfo<Parameter>& info) {
  return name_of(info.param);
}

/// All of them; GlTest skips those that the machine lacks.
inline constexpr host::HostGl kImplementations[] = {host::HostGl::egl, host::HostGl::osmesa,
                                                    host::HostGl::angle};

/// The same as parameters of a suite.
template <class Parameter>
std::vector<Parameter> implementations() {
  return {std::begin(kImplementations), std::end(kImplementations)};
}

/// With compute shaders, and without (where OSMesa is what Mesa by EGL is); in vertices on one.
inline std::vector<GlForm> all_forms() {
  std::vector<GlForm> forms = implementations<GlForm>();
  for (const host::HostGl gl : {host::HostGl::egl, host::HostGl::angle})
    forms.emplace_back(gl, Stage::fragments);
  forms.emplace_back(host::HostGl::angle, Stage::vertices);
  return forms;
}

}  // namespace fluxgs::test

#define FLUXGS_GL_TEST_SUITE(suite)                                                              \
  INSTANTIATE_TEST_SUITE_P(Gl, suite,                                                            \
                           testing::ValuesIn(fluxgs::test::implementations<suite::ParamType>()), \
                           fluxgs::test::implementation_name<suite::ParamType>)

/// For suites of GlTest whose pictures must come out in either form.
#define FLUXGS_GL_FORMS_TEST_SUITE(suite)                                           \
  INSTANTIATE_TEST_SUITE_P(Gl, suite, testing::ValuesIn(fluxgs::test::all_forms()), \
                           fluxgs::test::implementation_name<fluxgs::test::GlForm>)
