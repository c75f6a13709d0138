// EGL and the windows of Android, played: what the screen of a phone asks for is answered as a
// driver would, with the failures that a test wants, and what it must not do is written down.
#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

// clang-format off
#include <EGL/egl.h>
#include <android/native_window.h>
// clang-format on

#include "platform/host/host_context.h"

struct ANativeWindow {
  int references = 1;              ///< of the screen
  EGLSurface connected = nullptr;  ///< at most one surface may be made for a window
  bool abandoned = false;          ///< its Surface is gone: buffers are refused
  int geometry = 0;                ///< format that was asked for
  int shown = 0;                   ///< images
  std::vector<long> times = {};    ///< of the frames of a video, nanoseconds
};

namespace fluxgs::test {

struct MockSurface {
  ANativeWindow* window = nullptr;  ///< null: a pbuffer
  bool doomed = false;              ///< destroyed while it was current
};

/// The state of the one display.
struct MockEgl {
  /// Errors of the next calls of a function, by its name; EGL_SUCCESS lets one pass.
  std::map<std::string, std::deque<EGLint>> failures;
  std::vector<std::string> misuse;  ///< one line each
  std::map<EGLSurface, MockSurface> surfaces;
  std::set<EGLContext> contexts;
  EGLSurface current = EGL_NO_SURFACE;
  EGLContext current_context = EGL_NO_CONTEXT;
  bool initialized = false, terminated = false, thread_released = false;
  bool has_times = true;  ///< EGL_ANDROID_presentation_time
  bool lost = false;      ///< the context: every use of it says so
  EGLint error = EGL_SUCCESS;
  long calls = 0;
  std::size_t next = 1;                   ///< handle
  std::unique_ptr<host::HostContext> gl;  ///< whose functions are given out

  /// True, with the error set, if this call is to fail.
  bool fails(const char* function);
  void wrong(const std::string& what) { misuse.push_back(what); }
  /// Lets go of what was only kept because it was current.
  void sweep();
};
inline MockEgl mock;

}  // namespace fluxgs::test
