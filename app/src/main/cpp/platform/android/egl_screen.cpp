#include "platform/android/egl_screen.h"

// clang-format off
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <android/native_window.h>
#include <dlfcn.h>
// clang-format on

#include <algorithm>
#include <cstdio>
#include <initializer_list>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace fluxgs::android {
namespace {

std::string hexadecimal(EGLint error) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%x", static_cast<unsigned>(error));
  return text;
}

std::unexpected<Error> egl_failure(const char* what, EGLint error = eglGetError()) {
  return fail("EGL", what, "failed with error " + hexadecimal(error));
}

/// surface_destroyed() is on its way.
bool window_is_going(EGLint error) {
  return error == EGL_BAD_SURFACE || error == EGL_BAD_NATIVE_WINDOW;
}

/// Drivers need not return functions of the core API from eglGetProcAddress() before EGL 1.5.
void* function(const char* name) {
  static void* const library = dlopen("libGLESv3.so", RTLD_NOW | RTLD_LOCAL);
  if (library != nullptr)
    if (void* found = dlsym(library, name)) return found;
  return reinterpret_cast<void*>(eglGetProcAddress(name));
}

constexpr EGLint kRecordable = 0x3142;  // EGL_RECORDABLE_ANDROID

class EglScreen final : public viewer::Screen {
 public:
  ~EglScreen() override {
    end_video();
    detach();
    drop_context();
    if (display_ != EGL_NO_DISPLAY) eglTerminate(display_);
    eglReleaseThread();
  }

  Expected<gl::Api*> make_context() override {
    drop_context();
    if (auto opened = open_display(); !opened) return std::unexpected(opened.error());
    if (auto made = create_context(); !made) return std::unexpected(made.error());
    if (const EGLint error = make_current(idle_surface_); error != EGL_SUCCESS)
      return egl_failure("eglMakeCurrent", error);
    auto api = gl::load_api(function);
    if (!api) return std::unexpected(api.error());
    api_ = std::move(*api);
    return api_.get();
  }
  gl::Api* api() override { return api_.get(); }

  void attach(void* window) override {
    detach();
    window_ = static_cast<ANativeWindow*>(window);
  }

  void detach() override {
    destroy_surface();
    if (window_ != nullptr) ANativeWindow_release(std::exchange(window_, nullptr));
  }
  bool has_window() const override { return window_ != nullptr; }

  Expected<bool> present(const std::function<void()>& draw, int width, int height) override {
    if (const auto there = make_surface({width, height}); !there || !*there) return there;
    draw();
    if (eglSwapBuffers(display_, window_surface_) == EGL_TRUE) return true;
    const EGLint error = eglGetError();
    if (error == EGL_CONTEXT_LOST) api_->lost = true;
    destroy_surface();  // the next frame tries again
    if (window_is_going(error)) return false;
    return egl_failure("eglSwapBuffers", error);
  }

  Expected<void> begin_video(void* window) override {
    end_video();
    video_window_ = static_cast<ANativeWindow*>(window);
    if (context_ == EGL_NO_CONTEXT) return fail("EGL", "video", "there is no context");
    present_at_ =
        reinterpret_cast<PresentationTime>(eglGetProcAddress("eglPresentationTimeANDROID"));
    if (present_at_ == nullptr)
      return fail("EGL", "video",
                  "this device gives frames no times (EGL_ANDROID_presentation_time)");
    video_surface_ = create_surface(video_window_);
    if (video_surface_ == EGL_NO_SURFACE) return egl_failure("eglCreateWindowSurface");
    return {};
  }

  Expected<void> video_frame(const std::function<void()>& draw, std::int64_t nanoseconds) override {
    if (const EGLint error = make_current(video_surface_); error != EGL_SUCCESS)
      return egl_failure("eglMakeCurrent", error);
    draw();
    if (present_at_(display_, video_surface_, nanoseconds) != EGL_TRUE)
      return lost_or_failure("eglPresentationTimeANDROID");
    if (eglSwapBuffers(display_, video_surface_) != EGL_TRUE)
      return lost_or_failure("eglSwapBuffers");
    if (const EGLint error = make_current(idle_surface_); error != EGL_SUCCESS)
      return egl_failure("eglMakeCurrent", error);
    return {};
  }

  void end_video() override {
    if (video_surface_ != EGL_NO_SURFACE) {
      be_idle();  // a frame that failed has left it current
      eglDestroySurface(display_, std::exchange(video_surface_, EGL_NO_SURFACE));
    }
    if (video_window_ != nullptr) ANativeWindow_release(std::exchange(video_window_, nullptr));
  }

 private:
  using PresentationTime = EGLBoolean (*)(EGLDisplay, EGLSurface, std::int64_t);

  std::unexpected<Error> lost_or_failure(const char* what) {
    const EGLint error = eglGetError();
    if (error == EGL_CONTEXT_LOST) api_->lost = true;
    return egl_failure(what, error);
  }

  struct Size {
    int width = 0, height = 0;
    bool operator==(const Size&) const = default;
  };

  /// For a window without buffers of that size: buffers that a driver has taken already keep the
  /// size that the window had before, and nobody would draw a second frame of a view at rest.
  /// True if there is one then.
  Expected<bool> make_surface(const Size& size) {
    if (size != size_) destroy_surface();
    if (window_ == nullptr) return false;
    if (window_surface_ == EGL_NO_SURFACE) {
      window_surface_ = create_surface(window_);
      if (window_surface_ == EGL_NO_SURFACE) {
        const EGLint error = eglGetError();
        if (window_is_going(error)) return false;
        return egl_failure("eglCreateWindowSurface", error);
      }
      size_ = size;
    }
    if (current_ == window_surface_) return true;
    const EGLint error = make_current(window_surface_);
    if (error == EGL_SUCCESS) return true;
    destroy_surface();
    if (window_is_going(error)) return false;
    return egl_failure("eglMakeCurrent", error);
  }

  Expected<void> open_display() {
    if (config_ != nullptr) return {};  // else it failed before, or was never tried
    display_ = eglGetDisplay(EGL_DEFAULT_DISPLAY);
    if (display_ == EGL_NO_DISPLAY || eglInitialize(display_, nullptr, nullptr) != EGL_TRUE)
      return egl_failure("eglInitialize");
    const EGLint wanted[] = {EGL_RENDERABLE_TYPE,
                             EGL_OPENGL_ES3_BIT,
                             EGL_SURFACE_TYPE,
                             EGL_WINDOW_BIT | EGL_PBUFFER_BIT,
                             EGL_RED_SIZE,
                             8,
                             EGL_GREEN_SIZE,
                             8,
                             EGL_BLUE_SIZE,
                             8,
                             EGL_NONE};
    EGLint count = 0;
    if (eglChooseConfig(display_, wanted, nullptr, 0, &count) != EGL_TRUE)
      return egl_failure("eglChooseConfig");
    std::vector<EGLConfig> configs(static_cast<std::size_t>(std::max(count, 0)));
    if (eglChooseConfig(display_, wanted, configs.data(), count, &count) != EGL_TRUE)
      return egl_failure("eglChooseConfig");
    if (count < 1) return fail("EGL", "config", "this device has no OpenGL ES 3.1");
    configs.resize(static_cast<std::size_t>(count));
    config_ = *std::ranges::min_element(configs, {}, [this](EGLConfig c) { return rank_of(c); });
    return {};
  }

  int attribute_of(EGLConfig config, EGLint name) const {
    EGLint value = 0;
    eglGetConfigAttrib(display_, config, name, &value);
    return value;
  }

  /// The least is the best: fast, of 4 bytes a pixel, which displays compress, one that encoders of
  /// videos take, and without bits of which the image has no use, such as 10 a colour, though
  /// drivers name those first.
  std::tuple<bool, bool, bool, int> rank_of(EGLConfig config) const {
    constexpr int kRgba8888 = 1, kRgbx8888 = 2;  // of AHardwareBuffer_Format
    const int layout = attribute_of(config, EGL_NATIVE_VISUAL_ID);
    return {attribute_of(config, EGL_CONFIG_CAVEAT) == EGL_SLOW_CONFIG,
            layout != kRgba8888 && layout != kRgbx8888,
            attribute_of(config, kRecordable) != EGL_TRUE, bits_of(config)};
  }

  /// Bits of a pixel, of all its channels.
  int bits_of(EGLConfig config) const {
    int bits = 0;
    for (const EGLint part : {EGL_RED_SIZE, EGL_GREEN_SIZE, EGL_BLUE_SIZE, EGL_ALPHA_SIZE,
                              EGL_DEPTH_SIZE, EGL_STENCIL_SIZE, EGL_SAMPLES})
      bits += attribute_of(config, part);
    return bits;
  }

  /// With the promise to be told of a reset, where the driver gives it.
  Expected<void> create_context() {
    for (const bool robust : {true, false}) {
      std::vector<EGLint> attributes = {EGL_CONTEXT_MAJOR_VERSION_KHR, 3,
                                        EGL_CONTEXT_MINOR_VERSION_KHR, 1};
      if (robust)
        attributes.insert(attributes.end(), {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY_EXT,
                                             EGL_LOSE_CONTEXT_ON_RESET_EXT});
      attributes.push_back(EGL_NONE);
      context_ = eglCreateContext(display_, config_, EGL_NO_CONTEXT, attributes.data());
      if (context_ != EGL_NO_CONTEXT) break;
    }
    if (context_ == EGL_NO_CONTEXT)
      return fail("EGL", "context",
                  "this device has no OpenGL ES 3.1 (error " + hexadecimal(eglGetError()) + ")");
    const EGLint size[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
    idle_surface_ = eglCreatePbufferSurface(display_, config_, size);
    if (idle_surface_ == EGL_NO_SURFACE) return egl_failure("eglCreatePbufferSurface");
    return {};
  }

  EGLSurface create_surface(ANativeWindow* window) const {
    ANativeWindow_setBuffersGeometry(window, 0, 0, attribute_of(config_, EGL_NATIVE_VISUAL_ID));
    return eglCreateWindowSurface(display_, config_, window, nullptr);
  }

  void destroy_surface() {
    if (window_surface_ == EGL_NO_SURFACE) return;
    be_idle();
    eglDestroySurface(display_, window_surface_);
    window_surface_ = EGL_NO_SURFACE;
  }

  /// No surface but the idle one stays current: it would only be marked for deletion, and keep its
  /// window.
  void be_idle() {
    if (make_current(idle_surface_) == EGL_SUCCESS) return;
    let_go();
    if (api_) api_->lost = true;  // nothing more reaches it
  }

  void let_go() {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    current_ = EGL_NO_SURFACE;
  }

  EGLint make_current(EGLSurface surface) {
    if (eglMakeCurrent(display_, surface, surface, context_) == EGL_TRUE) {
      current_ = surface;
      return EGL_SUCCESS;
    }
    const EGLint error = eglGetError();
    if (error == EGL_CONTEXT_LOST && api_) api_->lost = true;
    return error;
  }

  void drop_context() {
    api_.reset();
    if (display_ == EGL_NO_DISPLAY) return;
    let_go();
    for (EGLSurface* surface : {&window_surface_, &video_surface_, &idle_surface_}) {
      if (*surface != EGL_NO_SURFACE) eglDestroySurface(display_, *surface);
      *surface = EGL_NO_SURFACE;
    }
    if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
    context_ = EGL_NO_CONTEXT;
  }

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLConfig config_ = nullptr;
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLSurface window_surface_ = EGL_NO_SURFACE;
  EGLSurface idle_surface_ = EGL_NO_SURFACE;  // of one pixel, while there is no window
  EGLSurface current_ = EGL_NO_SURFACE;
  ANativeWindow* window_ = nullptr;
  EGLSurface video_surface_ = EGL_NO_SURFACE;
  ANativeWindow* video_window_ = nullptr;  // of an encoder
  PresentationTime present_at_ = nullptr;
  Size size_;  // of the window, when the surface was made
  std::unique_ptr<gl::Api> api_;
};

}  // namespace

std::unique_ptr<viewer::Screen> make_egl_screen() { return std::make_unique<EglScreen>(); }

}  // namespace fluxgs::android
