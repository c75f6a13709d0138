// A window of the desktop with an OpenGL ES 3.1 context, and what people do in it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "platform/host/host_context.h"
#include "render/render_target.h"

namespace fluxgs::host {

enum class PointerButton { left, middle, right };

/// Escape as WindowEvent::key; other keys are the capital letter or the digit that they have on a
/// US keyboard, so that they lie in the same places on every keyboard.
inline constexpr char kEscape = 27;

struct WindowEvent {
  enum class Kind {
    pointer_moved,  ///< position
    button,         ///< button, down, position
    scrolled,       ///< amount: notches, away from the user > 0; position
    key,            ///< key, down
    text,           ///< key: an ASCII character that was typed, whatever the keyboard
    focus_lost,     ///< keys that are down will not be reported as lifted
    uncovered,      ///< the window's content must be drawn again
  };
  Kind kind = Kind::uncovered;
  glm::dvec2 position{0.0};  ///< px of the framebuffer, from its top left corner
  PointerButton button = PointerButton::left;
  bool down = false;
  double amount = 0;
  char key = 0;
};

struct WindowSize {
  int width = 0, height = 0;  ///< px of the framebuffer; 0 while minimised
  bool operator==(const WindowSize&) const = default;
};

/// One window; another may be made once it is gone. To be used on the main thread only. As a
/// HostContext it can share the process with those without a window.
class Window : public HostContext {
 public:
  virtual WindowSize size() const = 0;
  virtual void resize(const WindowSize& size) = 0;
  virtual void set_title(const std::string& title) = 0;
  /// Whether the user wants it closed.
  virtual bool close_requested() const = 0;
  /// What has happened since the last call. With nothing to tell, waits up to `seconds` for
  /// something.
  virtual std::vector<WindowEvent> events(double seconds) = 0;
  /// Shows what was drawn to the window's framebuffer; waits for the display's next frame if
  /// `wait_for_display` was set.
  virtual void present() = 0;
};

struct WindowOptions {
  std::string title;
  WindowSize size{1280, 720};
  bool wait_for_display = true;
};

/// Opens a window and makes its context current on this thread. Errors: the library (GLFW, loaded
/// at run time) or the display is missing, or the driver has no OpenGL ES 3.1.
Expected<std::unique_ptr<Window>> open_window(const WindowOptions& options);

/// The version of the library that opens windows, whether or not there is a display.
Expected<std::string> window_library_version();

/// What is in the window's framebuffer: RGB, top row first. To be called before present(), which
/// leaves nothing defined there. Waits for the GPU.
Expected<Image<std::uint8_t>> read_window(gl::Api& api, const WindowSize& size);

}  // namespace fluxgs::host
