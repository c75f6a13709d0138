#include "gl/debug_log.h"

#include <algorithm>
#include <iterator>

#include "gl/api.h"

namespace fluxgs::gl {
namespace {

Severity severity_of(GLenum value) {
  switch (value) {
    case GL_DEBUG_SEVERITY_HIGH_KHR:
      return Severity::high;
    case GL_DEBUG_SEVERITY_MEDIUM_KHR:
      return Severity::medium;
    case GL_DEBUG_SEVERITY_LOW_KHR:
      return Severity::low;
    default:
      return Severity::notification;
  }
}

MessageKind kind_of(GLenum type) {
  switch (type) {
    case GL_DEBUG_TYPE_ERROR_KHR:
    case GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR_KHR:
      return MessageKind::error;
    case GL_DEBUG_TYPE_PERFORMANCE_KHR:
      return MessageKind::performance;
    default:
      return MessageKind::other;
  }
}

void GL_APIENTRY receive(GLenum, GLenum type, GLuint, GLenum severity, GLsizei length,
                         const GLchar* text, const void* user) {
  // The API's user pointer is const; the object behind it is not: hook_debug_messages passed it.
  auto* log = const_cast<DebugLog*>(static_cast<const DebugLog*>(user));
  if (log->messages.size() >= DebugLog::kCapacity) return;
  // A negative length means that the text ends with a zero.
  log->messages.push_back(
      {severity_of(severity), kind_of(type),
       length < 0 ? std::string(text) : std::string(text, static_cast<std::size_t>(length))});
}

}  // namespace

std::vector<DebugMessage> DebugLog::mistakes() const {
  std::vector<DebugMessage> found;
  std::ranges::copy_if(messages, std::back_inserter(found), [](const DebugMessage& m) {
    return m.kind == MessageKind::error ||
           (m.kind == MessageKind::other && m.severity >= Severity::medium);
  });
  return found;
}

void hook_debug_messages(Api& api) {
  if (!api.DebugMessageCallback) return;
  api.Enable(GL_DEBUG_OUTPUT_KHR);
  api.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS_KHR);
  api.DebugMessageCallback(receive, &api.debug);
}

}  // namespace fluxgs::gl
