// The screen of a viewer in a window of the desktop.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "viewer/screen.h"
#include "viewer/window_event.h"

namespace fluxgs::host {

struct WindowSize {
  int width = 0, height = 0;  ///< px of the framebuffer; 0 while minimised
};

/// One window, which is opened and closed with the context; attach() and detach() do nothing. To be
/// used on the main thread only, in a process where other contexts (HostContext) may be current
/// before and after.
class WindowScreen : public viewer::Screen {
 public:
  virtual WindowSize size() const = 0;
  virtual void resize(const WindowSize& size) = 0;
  virtual void set_title(const std::string& title) = 0;
  /// True if the user wants it closed.
  virtual bool close_requested() const = 0;
  /// The events since the last call. Without any, waits up to `seconds` for
  /// something.
  virtual std::vector<viewer::WindowEvent> events(double seconds) = 0;

  /// The next present() keeps an image of the window: RGB, top row first.
  virtual void capture_next() = 0;
  /// The image that was kept last, once.
  virtual std::optional<Image<std::uint8_t>> take_captured() = 0;
};

struct WindowOptions {
  std::string title;
  WindowSize size{1280, 720};
  bool wait_for_display = true;
};

/// Opens a window with an OpenGL ES 3.1 context that is current on this thread. Errors: the library
/// (GLFW, loaded at run time) or the display is missing, or the driver has no OpenGL ES 3.1.
Expected<std::unique_ptr<WindowScreen>> open_window(const WindowOptions& options);

/// The version of the library that opens windows, whether or not there is a display.
Expected<std::string> window_library_version();

}  // namespace fluxgs::host
