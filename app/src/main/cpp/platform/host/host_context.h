// A GL context on a desktop or server, without a window.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "fluxgs/error.h"
#include "gl/api.h"

namespace fluxgs::host {

enum class HostGl {
  egl,  ///< EGL without a surface: OpenGL ES 3.1 on the first graphics card, or on the CPU by Mesa
  osmesa,  ///< Mesa's off-screen library: desktop GL 4.5 on the CPU
  angle,   ///< ANGLE over SwiftShader, from angle_folder(): OpenGL ES 3.1 on the CPU
};

/// "egl", "osmesa" or "angle".
std::string_view name(HostGl implementation);
/// The other way round; fails on any other name.
Expected<HostGl> parse_host_gl(std::string_view name);

/// The folder of ANGLE's libraries: the one in the environment's FLUXGS_ANGLE_DIR, that of an
/// installed program (../lib/fluxgs/angle), or build/packages/angle, where tools/deps/angle puts
/// them.
std::string angle_folder();

/// Owns one context. Contexts may be made, and made current, in any number and order, on one
/// thread at a time each. All must be gone before exit(): drivers clean up there, before static
/// objects of ours would.
class HostContext {
 public:
  /// Makes the context and makes it current on this thread. The libraries are loaded at run time;
  /// the error for a missing one says what brings it.
  static Expected<std::unique_ptr<HostContext>> create(HostGl implementation);

  virtual ~HostContext() = default;
  HostContext(const HostContext&) = delete;
  HostContext& operator=(const HostContext&) = delete;

  /// Makes this the context of the calling thread, whichever implementation had one before.
  Expected<void> make_current();

  gl::Api& api() { return *api_; }
  /// The driver's own name, e.g. "llvmpipe (LLVM 15.0.6, 256 bits)".
  const std::string& renderer_string() const { return api_->capabilities.renderer; }

 protected:
  HostContext() = default;
  Expected<void> load(const gl::ProcLoader& loader);
  /// To be called first in the destructor of every implementation.
  void release();

  virtual bool bind() = 0;
  virtual void unbind() = 0;

 private:
  std::unique_ptr<gl::Api> api_;
};

// The implementations, each in its own file.
Expected<std::unique_ptr<HostContext>> create_egl_context();
Expected<std::unique_ptr<HostContext>> create_angle_context();
Expected<std::unique_ptr<HostContext>> create_osmesa_context();

}  // namespace fluxgs::host
