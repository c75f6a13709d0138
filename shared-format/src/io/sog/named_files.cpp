#include "io/sog/named_files.h"

#include <algorithm>
#include <ranges>

#include <fmt/format.h>

#include "fluxgs/sanitize.h"

namespace fluxgs::io {
namespace {

constexpr std::size_t kMaxName = 255;

bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

}  // namespace

bool is_plain_name(std::string_view file) {
  if (file.empty() || file.size() > kMaxName) return false;
  // A colon begins the path of "https:" and of "C:".
  if (std::ranges::any_of(file, [](char c) { return is_control(c) || c == '\\' || c == ':'; })) {
    return false;
  }
  for (const auto part : std::views::split(file, '/')) {
    const std::string_view step(part.begin(), part.end());
    if (step.empty() || step == "." || step == "..") return false;
  }
  return true;
}

Error name_error(const std::string& name, const std::string& field, std::string_view file) {
  return {name, field,
          fmt::format("\"{}\" is not read; expected the plain name of a file in the same folder",
                      sanitized(file))};
}

}  // namespace fluxgs::io
