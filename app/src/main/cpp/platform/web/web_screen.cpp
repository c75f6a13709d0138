#include "platform/web/web_screen.h"

#include <emscripten.h>

#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>

#include "platform/web/webgpu_device.h"
#include "render/blend_check.h"

namespace fluxgs::web {
namespace {

// clang-format off
EM_JS_DEPS(flux, "$stringToNewUTF8");
/// Makes the canvas's context current. False where the browser has none, or it is lost.
EM_JS(int, make_current, (), {
  const canvas = Module['canvas'];
  const gl = canvas.getContext('webgl2', {alpha: false, antialias: false, depth: false, stencil: false,
                                          powerPreference: 'high-performance'});
  if (!gl || gl.isContextLost()) return 0;
  const handle = GL.registerContext(gl, {majorVersion: 2, minorVersion: 0, enableExtensionsByDefault: 1});
  GL.makeContextCurrent(handle);
  return 1;
});
EM_JS(int, is_lost, (), { return GL.currentContext.GLctx.isContextLost() ? 1 : 0; });
/// The name of the GPU, where the browser tells it.
EM_JS(char*, unmasked_renderer, (), {
  const gl = GL.currentContext.GLctx;
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  return stringToNewUTF8(String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER)));
});
// clang-format on

// WebGL has no such function, and a page must not wait
void* map_nothing(GLenum, GLintptr, GLsizeiptr, GLbitfield) { return nullptr; }
GLboolean unmap_nothing(GLenum) { return GL_TRUE; }
GLenum look_at_fence(GLsync sync, GLbitfield flags, GLuint64) {
  return glClientWaitSync(sync, flags, 0);
}
GLenum reset_status() { return is_lost() != 0 ? GL_UNKNOWN_CONTEXT_RESET_KHR : GL_NO_ERROR; }

const GLubyte* get_string(GLenum name) {
  static std::string renderer;
  if (name != GL_RENDERER) return glGetString(name);
  char* const told = unmasked_renderer();
  renderer = told;
  std::free(told);
  return reinterpret_cast<const GLubyte*>(renderer.c_str());
}

void* other_function(const char* name) {
  const auto is = [name](const char* other) { return std::strcmp(name, other) == 0; };
  if (is("glMapBufferRange")) return reinterpret_cast<void*>(map_nothing);
  if (is("glUnmapBuffer")) return reinterpret_cast<void*>(unmap_nothing);
  if (is("glClientWaitSync")) return reinterpret_cast<void*>(look_at_fence);
  if (is("glGetString")) return reinterpret_cast<void*>(get_string);
  return nullptr;
}

void* function(const char* name) {
  if (void* const other = other_function(name)) return other;
#define FLUXGS_WEB_FUNCTION(gl_name) \
  if (std::strcmp(name, "gl" #gl_name) == 0) return reinterpret_cast<void*>(::gl##gl_name);
  FLUXGS_GL_WEB_FUNCTIONS(FLUXGS_WEB_FUNCTION)
#undef FLUXGS_WEB_FUNCTION
  return nullptr;
}

class WebScreen final : public viewer::Screen {
 public:
  Expected<gl::Api*> make_context() override {
    api_.reset();
    if (make_current() == 0)
      return fail("WebGL 2", "", "this browser has none, or the graphics card takes a break");
    auto made = gl::load_api(function);
    if (!made) return std::unexpected(made.error());
    api_ = std::move(*made);
    api_->GetGraphicsResetStatus = reset_status;
    const auto truncates = render::half_float_blending_truncates(*api_);
    api_->quirks.half_float_blending_truncates = truncates.value_or(false);
    return api_.get();
  }
  gl::Api* api() override { return gpu_ ? nullptr : api_.get(); }

  Expected<render::Device*> make_device() override {
    gpu_.reset();
    if (!WebGpuDevice::is_there()) return Screen::make_device();
    return &gpu_.emplace();
  }
  render::Device* device() override { return gpu_ ? &*gpu_ : Screen::device(); }

  void attach(void*) override {}
  void detach() override {}
  bool has_window() const override { return true; }

  Expected<bool> present(const std::function<void()>& draw, int, int) override {
    draw();
    if (device()->is_lost()) return fail("graphics card", "", "the context was lost");
    return true;
  }

 private:
  std::unique_ptr<gl::Api> api_;
  std::optional<WebGpuDevice> gpu_;
};

}  // namespace

std::unique_ptr<viewer::Screen> make_web_screen() { return std::make_unique<WebScreen>(); }

}  // namespace fluxgs::web
