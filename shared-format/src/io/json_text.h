// JSON from a stranger: size and depth are checked before a parser sees it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "fluxgs/error.h"

namespace fluxgs::io {

inline constexpr std::size_t kMaxJsonText = std::size_t(16) << 20;  ///< bytes
inline constexpr int kMaxJsonDepth = 64;                            ///< levels

/// Parse one JSON object within the bounds above, so that recursive code is safe on it. `field`
/// names the text in errors.
Expected<nlohmann::json> parse_json_object(std::string_view text, const std::string& name,
                                           const std::string& field);

inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The member of an object; null where there is none, or no object.
const nlohmann::json& member(const nlohmann::json& object, const char* key);

/// Text about a value for a message: "is missing", or "is 5".
std::string found(const nlohmann::json& value);

/// Short and on one line, for messages.
std::string shown(const nlohmann::json& value);

}  // namespace fluxgs::io
