// A point in the GPU's time. Timestamps are used instead of GL_TIME_ELAPSED, which reads 0 around
// compute dispatches on llvmpipe.
//
// See https://registry.khronos.org/OpenGL/extensions/EXT/EXT_disjoint_timer_query.txt
#pragma once

#include <cstdint>

#include "gl/handle.h"

namespace fluxgs::gl {

/// Needs Capabilities::timestamps.
class Timestamp {
 public:
  Timestamp() = default;
  explicit Timestamp(Api& api) {
    GLuint name = 0;
    api.GenQueries(1, &name);
    handle_ = {api, name};
  }

  /// Asks for the time at which everything before this call is finished.
  void record() const { handle_.api().QueryCounter(handle_.name(), GL_TIMESTAMP_EXT); }

  /// Waits for the GPU to get there; in nanoseconds since some start.
  std::uint64_t nanoseconds() const {
    GLuint64 value = 0;
    handle_.api().GetQueryObjectui64v(handle_.name(), GL_QUERY_RESULT, &value);
    return value;
  }

 private:
  static void destroy(Api& api, GLuint name) { api.DeleteQueries(1, &name); }
  Handle<destroy> handle_;
};

/// True if something, such as another clock rate of the GPU, has made the times since the last call
/// worthless. To be asked after they were read.
inline bool times_are_disjoint(Api& api) {
  if (!api.capabilities.is_es) return false;  // desktop GL knows no such thing
  GLint disjoint = 0;
  api.GetIntegerv(GL_GPU_DISJOINT_EXT, &disjoint);
  return disjoint != 0;
}

}  // namespace fluxgs::gl
