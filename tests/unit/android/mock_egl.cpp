#include "mock_egl.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <iterator>

using fluxgs::test::mock;
using fluxgs::test::MockSurface;

namespace fluxgs::test {

bool MockEgl::fails(const char* function) {
  ++calls;
  error = EGL_SUCCESS;
  const auto planned = failures.find(function);
  if (planned == failures.end() || planned->second.empty()) return false;
  error = planned->second.front();
  planned->second.pop_front();
  return error != EGL_SUCCESS;
}

void MockEgl::sweep() {
  std::erase_if(surfaces, [&](const auto& entry) {
    const auto& [surface, of] = entry;
    if (!of.doomed || surface == current) return false;
    if (of.window != nullptr) of.window->connected = nullptr;
    return true;
  });
}

namespace {

/// EGL's handles are pointers, here to bytes that nobody reads.
template <class Handle>
Handle new_handle() {
  static char bytes[1 << 20];
  return static_cast<Handle>(&bytes[mock.next++ % std::size(bytes)]);
}

EGLBoolean refuse(EGLint error) {
  mock.error = error;
  return EGL_FALSE;
}

struct Config {
  int red, alpha, layout;
  EGLint caveat;
};
/// As drivers sort them: 10 bits a colour first; the last one has the fewest bits.
constexpr Config kConfigs[] = {
    {10, 2, 43, EGL_NONE}, {8, 0, 2, EGL_SLOW_CONFIG}, {8, 8, 1, EGL_NONE}, {8, 0, 3, EGL_NONE}};

EGLBoolean present_at(EGLDisplay, EGLSurface surface, std::int64_t nanoseconds) {
  if (mock.fails("eglPresentationTimeANDROID")) return EGL_FALSE;
  if (surface != mock.current) mock.wrong("a frame gets a time that is not current");
  mock.surfaces[surface].window->times.push_back(nanoseconds);
  return EGL_TRUE;
}

const Config& config_of(EGLConfig config) { return *static_cast<const Config*>(config); }

}  // namespace
}  // namespace fluxgs::test

using namespace fluxgs::test;  // NOLINT(google-build-using-namespace)

extern "C" {

EGLint eglGetError() {
  const EGLint error = mock.error;
  mock.error = EGL_SUCCESS;
  return error;
}

__eglMustCastToProperFunctionPointerType eglGetProcAddress(const char* name) {
  using Function = __eglMustCastToProperFunctionPointerType;
  if (std::strcmp(name, "eglPresentationTimeANDROID") == 0)
    return mock.has_times ? reinterpret_cast<Function>(&present_at) : nullptr;
  const fluxgs::gl::Api& api = mock.gl->api();
#define FLUXGS_MOCK_GL(function)              \
  if (std::strcmp(name, "gl" #function) == 0) \
    return reinterpret_cast<__eglMustCastToProperFunctionPointerType>(api.function);
  FLUXGS_GL_FUNCTIONS(FLUXGS_MOCK_GL)
#undef FLUXGS_MOCK_GL
  return nullptr;
}

EGLDisplay eglGetDisplay(EGLNativeDisplayType) {
  return mock.fails("eglGetDisplay") ? EGL_NO_DISPLAY : static_cast<EGLDisplay>(&mock);
}

EGLBoolean eglInitialize(EGLDisplay, EGLint*, EGLint*) {
  if (mock.fails("eglInitialize")) return EGL_FALSE;
  mock.initialized = true;
  return EGL_TRUE;
}

EGLBoolean eglTerminate(EGLDisplay) {
  ++mock.calls;
  mock.terminated = true;
  return EGL_TRUE;
}

EGLBoolean eglReleaseThread() {
  ++mock.calls;
  mock.current = EGL_NO_SURFACE;
  mock.current_context = EGL_NO_CONTEXT;
  mock.thread_released = true;
  return EGL_TRUE;
}

EGLBoolean eglChooseConfig(EGLDisplay, const EGLint*, EGLConfig* configs, EGLint size,
                           EGLint* count) {
  if (mock.fails("eglChooseConfig")) return EGL_FALSE;
  const auto all = static_cast<EGLint>(std::size(kConfigs));
  *count = configs == nullptr ? all : std::min(size, all);
  for (EGLint i = 0; configs != nullptr && i < *count; ++i)
    configs[i] = const_cast<Config*>(&kConfigs[i]);
  return EGL_TRUE;
}

EGLBoolean eglGetConfigAttrib(EGLDisplay, EGLConfig config, EGLint attribute, EGLint* value) {
  ++mock.calls;
  const Config& c = config_of(config);
  switch (attribute) {
    case EGL_RED_SIZE:
    case EGL_GREEN_SIZE:
    case EGL_BLUE_SIZE:
      *value = c.red;
      break;
    case EGL_ALPHA_SIZE:
      *value = c.alpha;
      break;
    case EGL_NATIVE_VISUAL_ID:
      *value = c.layout;
      break;
    case EGL_CONFIG_CAVEAT:
      *value = c.caveat;
      break;
    default:
      *value = 0;
  }
  return EGL_TRUE;
}

EGLContext eglCreateContext(EGLDisplay, EGLConfig, EGLContext, const EGLint*) {
  if (mock.fails("eglCreateContext")) return EGL_NO_CONTEXT;
  mock.lost = false;
  return *mock.contexts.insert(new_handle<EGLContext>()).first;
}

EGLBoolean eglDestroyContext(EGLDisplay, EGLContext context) {
  ++mock.calls;
  if (context == mock.current_context) mock.wrong("a context is destroyed while it is current");
  if (mock.contexts.erase(context) == 0) mock.wrong("no such context is destroyed");
  return EGL_TRUE;
}

EGLSurface eglCreatePbufferSurface(EGLDisplay, EGLConfig, const EGLint*) {
  if (mock.fails("eglCreatePbufferSurface")) return EGL_NO_SURFACE;
  const auto surface = new_handle<EGLSurface>();
  mock.surfaces[surface] = {};
  return surface;
}

EGLSurface eglCreateWindowSurface(EGLDisplay, EGLConfig config, EGLNativeWindowType native,
                                  const EGLint*) {
  ANativeWindow* const window = native;
  if (mock.fails("eglCreateWindowSurface")) return EGL_NO_SURFACE;
  if (window->references < 1) mock.wrong("a window is used after it was released");
  if (window->abandoned) return refuse(EGL_BAD_NATIVE_WINDOW), EGL_NO_SURFACE;
  if (window->connected != nullptr) {
    mock.wrong("two surfaces for one window");
    return refuse(EGL_BAD_ALLOC), EGL_NO_SURFACE;
  }
  if (window->geometry != config_of(config).layout) mock.wrong("buffers of another format");
  const auto surface = new_handle<EGLSurface>();
  mock.surfaces[surface] = {.window = window};
  window->connected = surface;
  return surface;
}

EGLBoolean eglDestroySurface(EGLDisplay, EGLSurface surface) {
  ++mock.calls;
  const auto found = mock.surfaces.find(surface);
  if (found == mock.surfaces.end() || found->second.doomed) {
    mock.wrong("no such surface is destroyed");
    return refuse(EGL_BAD_SURFACE);
  }
  found->second.doomed = true;
  mock.sweep();
  return EGL_TRUE;
}

EGLBoolean eglMakeCurrent(EGLDisplay, EGLSurface draw, EGLSurface, EGLContext context) {
  // Nothing can keep a thread from letting go
  if (context != EGL_NO_CONTEXT && mock.fails("eglMakeCurrent")) return EGL_FALSE;
  if (context != EGL_NO_CONTEXT) {
    if (mock.lost) return refuse(EGL_CONTEXT_LOST);
    if (!mock.contexts.contains(context)) return refuse(EGL_BAD_CONTEXT);
    if (!mock.surfaces.contains(draw)) return refuse(EGL_BAD_SURFACE);
    const ANativeWindow* window = mock.surfaces[draw].window;
    if (window != nullptr && window->abandoned) return refuse(EGL_BAD_NATIVE_WINDOW);
  }
  mock.current = draw;
  mock.current_context = context;
  mock.sweep();
  return EGL_TRUE;
}

EGLBoolean eglSwapBuffers(EGLDisplay, EGLSurface surface) {
  if (mock.fails("eglSwapBuffers")) return EGL_FALSE;
  if (mock.lost) return refuse(EGL_CONTEXT_LOST);
  const auto found = mock.surfaces.find(surface);
  if (found == mock.surfaces.end()) return refuse(EGL_BAD_SURFACE);
  if (surface != mock.current) mock.wrong("a surface is shown that is not current");
  ANativeWindow* window = found->second.window;
  if (window == nullptr || window->abandoned) return refuse(EGL_BAD_SURFACE);
  ++window->shown;
  return EGL_TRUE;
}

void ANativeWindow_release(ANativeWindow* window) {
  if (--window->references < 0) mock.wrong("a window is released twice");
  if (window->connected != nullptr) mock.wrong("a window is released under its surface");
}

std::int32_t ANativeWindow_setBuffersGeometry(ANativeWindow* window, std::int32_t, std::int32_t,
                                              std::int32_t format) {
  if (window->references < 1) mock.wrong("a window is used after it was released");
  window->geometry = format;
  return 0;
}
}
