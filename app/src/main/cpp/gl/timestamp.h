// A point in the GPU's time. Timestamps are used instead of GL_TIME_ELAPSED, which reads 0 around
// compute dispatches on llvmpipe.
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

}  // namespace fluxgs::gl
