// A point in the GPU's work that one can ask for without waiting (ES 3.1, 4.1).
#pragma once

#include <chrono>
#include <utility>

#include "gl/api.h"

namespace fluxgs::gl {

/// Passed when everything before its creation is finished. Move-only; its context must be current,
/// or lost, and the Api must outlive it.
class Fence {
 public:
  Fence() = default;
  explicit Fence(Api& api) : api_(&api), sync_(api.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0)) {}
  Fence(Fence&& other) noexcept
      : api_(other.api_), sync_(std::exchange(other.sync_, GLsync{nullptr})) {}
  Fence& operator=(Fence&& other) noexcept {
    std::swap(api_, other.api_);
    std::swap(sync_, other.sync_);
    return *this;
  }
  ~Fence() {
    if (sync_ != nullptr && !api_->lost) api_->DeleteSync(sync_);
  }

  bool passed() const {
    if (sync_ == nullptr) return false;
    const GLenum state = api_->ClientWaitSync(sync_, 0, 0);
    return state == GL_ALREADY_SIGNALED || state == GL_CONDITION_SATISFIED;
  }

  /// Waits for it, so long at most; whether it has passed.
  bool wait(std::chrono::nanoseconds timeout) const {
    if (sync_ == nullptr) return false;
    const GLenum state = api_->ClientWaitSync(sync_, GL_SYNC_FLUSH_COMMANDS_BIT,
                                              static_cast<GLuint64>(timeout.count()));
    return state == GL_ALREADY_SIGNALED || state == GL_CONDITION_SATISFIED;
  }

 private:
  Api* api_ = nullptr;
  GLsync sync_ = nullptr;
};

}  // namespace fluxgs::gl
