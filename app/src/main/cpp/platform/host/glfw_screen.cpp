// Windows through GLFW, which is loaded at run time like the other libraries of this folder.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <utility>

#include "platform/host/dynamic_library.h"
#include "platform/host/host_context.h"
#include "platform/host/window_screen.h"

// clang-format off
#define FLUXGS_GLFW_FUNCTIONS(X) \
  X(CreateWindow) X(DestroyWindow) X(GetCursorPos) X(GetError) X(GetFramebufferSize) \
  X(GetProcAddress) X(GetVersionString) X(GetWindowSize) X(GetWindowUserPointer) X(Init) \
  X(MakeContextCurrent) X(PollEvents) X(SetCharCallback) X(SetCursorPosCallback) \
  X(SetFramebufferSizeCallback) X(SetKeyCallback) X(SetMouseButtonCallback) \
  X(SetScrollCallback) X(SetWindowFocusCallback) X(SetWindowRefreshCallback) X(SetWindowSize) \
  X(SetWindowTitle) X(SetWindowUserPointer) X(SwapBuffers) X(SwapInterval) \
  X(WaitEventsTimeout) X(WindowHint) X(WindowShouldClose)
// clang-format on

namespace fluxgs::host {
namespace {

using viewer::PointerButton;
using viewer::WindowEvent;

struct Glfw {
  DynamicLibrary library;
// NOLINTNEXTLINE(bugprone-macro-parentheses): it is a name, not an expression
#define FLUXGS_GLFW_MEMBER(name) decltype(&::glfw##name) name = nullptr;
  FLUXGS_GLFW_FUNCTIONS(FLUXGS_GLFW_MEMBER)
#undef FLUXGS_GLFW_MEMBER
};

Expected<Glfw> load_glfw() {
  auto library =
      DynamicLibrary::open({"libglfw.so.3"}, "windows need it: install the package libglfw3");
  if (!library) return std::unexpected(library.error());
  Glfw glfw;
  glfw.library = *library;
  bool complete = true;
#define FLUXGS_GLFW_LOAD(name)            \
  library->load(glfw.name, "glfw" #name); \
  complete = complete && glfw.name != nullptr;
  FLUXGS_GLFW_FUNCTIONS(FLUXGS_GLFW_LOAD)
#undef FLUXGS_GLFW_LOAD
  if (complete) return glfw;
  return fail("libglfw.so.3", "", "lacks functions of GLFW 3.3");
}

const Expected<Glfw>& glfw_library() {
  static const Expected<Glfw> glfw = load_glfw();
  return glfw;
}

/// GLFW's text about its last failure.
std::string reason(const Glfw& glfw) {
  const char* text = nullptr;
  glfw.GetError(&text);
  return text ? text : "no reason given";
}

/// Pixels of the window's framebuffer, whose row 0 is at the bottom. Waits for the GPU.
Expected<Image<std::uint8_t>> read_window(gl::Api& api, int width, int height) {
  Image<std::uint8_t> image(width, height, 3);
  std::vector<std::uint8_t> rgba(4 * image.pixels.size() / 3);
  api.BindFramebuffer(GL_FRAMEBUFFER, 0);
  api.PixelStorei(GL_PACK_ALIGNMENT, 4);
  gl::clear_errors(api);
  api.ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  if (auto ok = gl::check_errors(api, "glReadPixels"); !ok) return std::unexpected(ok.error());
  const std::uint8_t* from = rgba.data();
  for (int y = height - 1; y >= 0; --y)
    for (int x = 0; x < width; ++x, from += 4) std::copy_n(from, 3, image.at(x, y));
  return image;
}

class GlfwScreen final : public WindowScreen, private HostContext {
 public:
  GlfwScreen(const Glfw& glfw, WindowOptions options) : glfw_(glfw), options_(std::move(options)) {}
  ~GlfwScreen() override { close(); }

  Expected<gl::Api*> make_context() override {
    if (window_ && size().width > 0) options_.size = size();
    close();
    auto opened = open();
    if (opened) return api();
    close();
    return std::unexpected(opened.error());
  }
  gl::Api* api() override { return window_ ? &HostContext::api() : nullptr; }

  void attach(void* /*window*/) override {}
  void detach() override {}
  bool has_window() const override { return window_ != nullptr; }

  Expected<bool> present(const std::function<void()>& draw, int width, int height) override {
    draw();
    if (std::exchange(captures_, false)) {
      auto image = read_window(*api(), width, height);  // Nothing is defined there afterwards
      if (!image) return std::unexpected(image.error());
      captured_ = std::move(*image);
    }
    glfw_.SwapBuffers(window_);
    return true;
  }

  WindowSize size() const override {
    WindowSize size;
    glfw_.GetFramebufferSize(window_, &size.width, &size.height);
    return size;
  }
  void resize(const WindowSize& size) override {
    glfw_.SetWindowSize(window_, size.width, size.height);
  }
  void set_title(const std::string& title) override {
    options_.title = title;
    glfw_.SetWindowTitle(window_, title.c_str());
  }
  bool close_requested() const override { return glfw_.WindowShouldClose(window_) == GLFW_TRUE; }

  std::vector<WindowEvent> events(double seconds) override {
    if (seconds > 0)
      glfw_.WaitEventsTimeout(seconds);
    else
      glfw_.PollEvents();
    return std::exchange(events_, {});
  }

  void capture_next() override { captures_ = true; }
  std::optional<Image<std::uint8_t>> take_captured() override {
    return std::exchange(captured_, std::nullopt);
  }

 private:
  void close() {
    release();
    if (window_) glfw_.DestroyWindow(std::exchange(window_, nullptr));
  }

  Expected<void> open() {
    // Once is enough, and there is no end: glfwTerminate() would unload the driver's libraries and
    // close the display that other contexts may share
    if (glfw_.Init() != GLFW_TRUE) {
      return fail("window", "",
                  "no display to open it on (" + reason(glfw_) +
                      "); expected a graphical session (DISPLAY), or use fluxgs render");
    }
    // Not every driver tells when the GPU was reset
    for (const bool reset_notification : {true, false}) {
      hint(reset_notification);
      window_ = glfw_.CreateWindow(options_.size.width, options_.size.height,
                                   options_.title.c_str(), nullptr, nullptr);
      if (window_) break;
    }
    if (!window_) {
      return fail("window", "",
                  "the display offers no OpenGL ES 3.1 through EGL (" + reason(glfw_) +
                      "); install the packages libegl1 and libegl-mesa0, or use fluxgs render");
    }
    listen();
    auto loaded = load(
        [this](const char* name) { return reinterpret_cast<void*>(glfw_.GetProcAddress(name)); });
    if (loaded) glfw_.SwapInterval(options_.wait_for_display ? 1 : 0);
    return loaded;
  }

  bool bind() override {
    glfw_.GetError(nullptr);  // forgets what was before
    glfw_.MakeContextCurrent(window_);
    return glfw_.GetError(nullptr) == GLFW_NO_ERROR;
  }
  void unbind() override { glfw_.MakeContextCurrent(nullptr); }

  void hint(bool reset_notification) const {
    glfw_.WindowHint(GLFW_CONTEXT_ROBUSTNESS,
                     reset_notification ? GLFW_LOSE_CONTEXT_ON_RESET : GLFW_NO_ROBUSTNESS);
    glfw_.WindowHint(GLFW_CLIENT_API, GLFW_OPENGL_ES_API);
    glfw_.WindowHint(GLFW_CONTEXT_CREATION_API, GLFW_EGL_CONTEXT_API);
    glfw_.WindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfw_.WindowHint(GLFW_CONTEXT_VERSION_MINOR, 1);
    // Images are finished before they come here. An alpha channel would let desktops shine
    // through.
    glfw_.WindowHint(GLFW_ALPHA_BITS, 0);
    glfw_.WindowHint(GLFW_DEPTH_BITS, 0);
    glfw_.WindowHint(GLFW_STENCIL_BITS, 0);
  }

  using Kind = WindowEvent::Kind;
  static GlfwScreen& self(GLFWwindow* window) {
    return *static_cast<GlfwScreen*>(glfw_library()->GetWindowUserPointer(window));
  }
  static void tell(GLFWwindow* window, const WindowEvent& event) {
    self(window).events_.push_back(event);
  }

  /// Converts the window's units to pixels, which differ where the desktop enlarges windows.
  glm::dvec2 in_pixels(double x, double y) const {
    int width = 0, height = 0;
    glfw_.GetWindowSize(window_, &width, &height);
    const WindowSize pixels = size();
    if (width < 1 || height < 1) return {x, y};
    return {x * pixels.width / width, y * pixels.height / height};
  }
  glm::dvec2 pointer() const {
    double x = 0, y = 0;
    glfw_.GetCursorPos(window_, &x, &y);
    return in_pixels(x, y);
  }

  static void on_button(GLFWwindow* window, int button, int action, int /*modifiers*/) {
    if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
    const PointerButton which = button == GLFW_MOUSE_BUTTON_LEFT    ? PointerButton::left
                                : button == GLFW_MOUSE_BUTTON_RIGHT ? PointerButton::right
                                                                    : PointerButton::middle;
    tell(window, {.kind = Kind::button,
                  .position = self(window).pointer(),
                  .button = which,
                  .down = action == GLFW_PRESS});
  }

  static void on_key(GLFWwindow* window, int key, int /*scancode*/, int action, int /*modifiers*/) {
    const bool letter_or_digit =
        (key >= GLFW_KEY_A && key <= GLFW_KEY_Z) || (key >= GLFW_KEY_0 && key <= GLFW_KEY_9);
    if (action == GLFW_REPEAT || (!letter_or_digit && key != GLFW_KEY_ESCAPE)) return;
    tell(window, {.kind = Kind::key,
                  .down = action == GLFW_PRESS,
                  .key = key == GLFW_KEY_ESCAPE ? viewer::kEscape : static_cast<char>(key)});
  }

  void listen() {
    glfw_.SetWindowUserPointer(window_, this);
    glfw_.SetMouseButtonCallback(window_, on_button);
    glfw_.SetKeyCallback(window_, on_key);
    glfw_.SetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) {
      tell(window, {.kind = Kind::pointer_moved, .position = self(window).in_pixels(x, y)});
    });
    glfw_.SetScrollCallback(window_, [](GLFWwindow* window, double, double y) {
      tell(window, {.kind = Kind::scrolled, .position = self(window).pointer(), .amount = y});
    });
    glfw_.SetCharCallback(window_, [](GLFWwindow* window, unsigned code) {
      if (code < 128) tell(window, {.kind = Kind::text, .key = static_cast<char>(code)});
    });
    glfw_.SetWindowFocusCallback(window_, [](GLFWwindow* window, int focused) {
      if (!focused) tell(window, {.kind = Kind::focus_lost});
    });
    glfw_.SetWindowRefreshCallback(
        window_, [](GLFWwindow* window) { tell(window, {.kind = Kind::uncovered}); });
    glfw_.SetFramebufferSizeCallback(
        window_, [](GLFWwindow* window, int, int) { tell(window, {.kind = Kind::uncovered}); });
  }

  const Glfw& glfw_;
  WindowOptions options_;
  GLFWwindow* window_ = nullptr;
  std::vector<WindowEvent> events_;
  bool captures_ = false;
  std::optional<Image<std::uint8_t>> captured_;
};

}  // namespace

Expected<std::unique_ptr<WindowScreen>> open_window(const WindowOptions& options) {
  const Expected<Glfw>& glfw = glfw_library();
  if (!glfw) return std::unexpected(glfw.error());
  auto screen = std::make_unique<GlfwScreen>(*glfw, options);
  if (auto opened = screen->make_context(); !opened) return std::unexpected(opened.error());
  return screen;
}

Expected<std::string> window_library_version() {
  const Expected<Glfw>& glfw = glfw_library();
  if (!glfw) return std::unexpected(glfw.error());
  return glfw->GetVersionString();
}

}  // namespace fluxgs::host
