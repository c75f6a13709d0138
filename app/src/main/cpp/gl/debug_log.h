// The driver's own messages about our use of it (KHR_debug).
#pragma once

#include <string>
#include <vector>

namespace fluxgs::gl {

struct Api;

enum class Severity { notification, low, medium, high };

enum class MessageKind { other, error, performance };

struct DebugMessage {
  Severity severity;
  MessageKind kind;  ///< undefined behaviour counts as error
  std::string text;
};

/// Messages in the order in which they came. At most kCapacity are kept, so that a message in
/// every frame cannot fill the memory.
struct DebugLog {
  static constexpr std::size_t kCapacity = 256;
  std::vector<DebugMessage> messages;

  /// The messages that mean a mistake of ours: errors, and anything of medium or high severity but
  /// advice on performance (reading an image back is slow, and meant).
  std::vector<DebugMessage> mistakes() const;
};

/// Has the driver report into api.debug, synchronously, which may slow it down: not for phones.
/// Does nothing without KHR_debug.
void hook_debug_messages(Api& api);

}  // namespace fluxgs::gl
