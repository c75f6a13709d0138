#include "io/json_text.h"

#include <algorithm>

#include <fmt/format.h>

#include "fluxgs/sanitize.h"

namespace fluxgs::io {
namespace {

using nlohmann::json;

// The deepest nesting of objects and arrays. Recursive code is safe below a limit of it.
int nesting(std::string_view text) {
  int depth = 0, deepest = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      deepest = std::max(deepest, ++depth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return deepest;
}

}  // namespace

Expected<json> parse_json_object(std::string_view text, const std::string& name,
                                 const std::string& field) {
  if (text.size() > kMaxJsonText) {
    return fail(name, field,
                fmt::format("holds {} bytes; expected at most {}", text.size(), kMaxJsonText));
  }
  if (const int depth = nesting(text); depth > kMaxJsonDepth) {
    return fail(name, field,
                fmt::format("is nested {} deep; expected at most {}", depth, kMaxJsonDepth));
  }
  try {
    json root = json::parse(text);
    if (!root.is_object()) return fail(name, field, "expected an object");
    return root;
  } catch (const json::parse_error& error) {
    return fail(name, field, fmt::format("is not JSON from byte {} on", error.byte));
  } catch (const json::exception& error) {
    return fail(name, field, sanitized(error.what(), 200));
  }
}

const json& member(const json& object, const char* key) {
  static const json kNothing;
  if (!object.is_object()) return kNothing;
  const auto found = object.find(key);
  return found != object.end() ? *found : kNothing;
}

std::string found(const json& value) {
  return value.is_null() ? "is missing" : "is " + shown(value);
}

std::string shown(const json& value) {
  std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  return text.size() > 80 ? text.substr(0, 77) + "..." : text;
}

}  // namespace fluxgs::io
