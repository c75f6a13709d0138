// Ownership of one GL name, shared by the object types of this folder.
#pragma once

#include <utility>

#include "gl/api.h"

namespace fluxgs::gl {

/// Owns a GL object and deletes it with Delete(api, name), unless its context was lost. Move-only.
/// The context must be current when a handle that owns something is destroyed, and the Api must
/// outlive it.
template <auto Delete>
class Handle {
 public:
  Handle() = default;
  Handle(Api& api, GLuint name) : api_(&api), name_(name) {}
  Handle(Handle&& other) noexcept
      : api_(other.api_), name_(std::exchange(other.name_, GLuint{0})) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(api_, other.api_);
    std::swap(name_, other.name_);
    return *this;
  }
  ~Handle() {
    if (name_ != 0 && !api_->lost) Delete(*api_, name_);
  }

  GLuint name() const { return name_; }
  Api& api() const { return *api_; }

 private:
  Api* api_ = nullptr;
  GLuint name_ = 0;
};

}  // namespace fluxgs::gl
