// Interface of a platform's screen: a graphics device, and a window that comes and goes.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "fluxgs/image.h"
#include "gl/api.h"
#include "render/gl_device.h"

namespace fluxgs::viewer {

/// All functions but the constructor are for one thread, the presenter's.
class Screen {
 public:
  Screen() = default;
  virtual ~Screen() = default;
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// A new context, current from now on, in place of any that there was; a window that is attached
  /// stays. Everything that was made in the old one must be gone, or that one lost. Fails where
  /// the device has no OpenGL ES 3.1.
  virtual Expected<gl::Api*> make_context() = 0;
  /// Null before make_context().
  virtual gl::Api* api() = 0;

  /// Makes a device to draw scenes with, in place of any that there was: OpenGL's, in a context of
  /// make_context(), unless the screen has another. Fails as that does.
  virtual Expected<render::Device*> make_device();
  /// Null where there is none yet.
  virtual render::Device* device();

  /// Images go to this window from now on; the platform's own handle, ownership of which is
  /// passed.
  virtual void attach(void* window) = 0;
  /// The window has been let go of when this returns.
  virtual void detach() = 0;
  virtual bool has_window() const = 0;

  /// Draws an image into the window's framebuffer, number 0, of that size, and shows it. Whether it
  /// did: not in a window that is about to be taken away, nor where there is none. Fails, with the
  /// context marked as lost (gl::context_lost()), when that is why.
  virtual Expected<bool> present(const std::function<void()>& draw, int width, int height) = 0;

  /// The images of a video go to this window of an encoder until end_video(); ownership is passed,
  /// also where it fails.
  virtual Expected<void> begin_video(void* window);
  /// Draws an image into the framebuffer, number 0, of that window, and hands it to the encoder
  /// with its time from the beginning. May wait for the encoder.
  virtual Expected<void> video_frame(const std::function<void()>& draw, std::int64_t nanoseconds);
  /// That window is no longer touched when this returns.
  virtual void end_video() {}

 private:
  std::optional<render::GlDevice> gl_device_;
};

}  // namespace fluxgs::viewer
