#include "gl/shader_log.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <system_error>

namespace fluxgs::gl {
namespace {

constexpr int kLinesPerFile = 1000;  // shaders/embed.cmake

/// Takes a number off the front of `rest`.
std::optional<int> take_number(std::string_view& rest) {
  int number = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
  if (error != std::errc() || number < 0) return {};
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  return number;
}

/// The file that a line of the text belongs to, or empty.
std::string_view file_of(int line, std::string_view name, std::string_view text) {
  const int first = line / kLinesPerFile * kLinesPerFile + 1;
  if (first == 1) return name;
  const std::string note = "\n// line " + std::to_string(first) + " is line 1 of ";
  const std::size_t at = text.find(note);
  if (at == text.npos) return {};
  text.remove_prefix(at + note.size());
  return text.substr(0, text.find('\n'));
}

std::string name_line(std::string_view message, std::string_view name, std::string_view text) {
  std::string_view rest = message;
  for (const std::string_view severity : {"ERROR: ", "WARNING: "})
    if (rest.starts_with(severity)) rest.remove_prefix(severity.size());
  std::string named(message.substr(0, message.size() - rest.size()));

  if (!take_number(rest)) return std::string(message);
  const bool in_brackets = rest.starts_with('(');
  if (!in_brackets && !rest.starts_with(':')) return std::string(message);
  rest.remove_prefix(1);
  const std::optional<int> line = take_number(rest);
  if (!line) return std::string(message);
  const std::string_view file = file_of(*line, name, text);
  if (file.empty()) return std::string(message);
  if (in_brackets && rest.starts_with(')')) rest.remove_prefix(1);
  return named.append(file).append(":").append(std::to_string(*line % kLinesPerFile)).append(rest);
}

}  // namespace

std::string name_lines(std::string_view log, std::string_view name, std::string_view text) {
  std::string named;
  while (!log.empty()) {
    const std::size_t end = std::min(log.find('\n'), log.size());
    named += name_line(log.substr(0, end), name, text);
    log.remove_prefix(end);
    if (!log.empty()) {
      named += '\n';
      log.remove_prefix(1);
    }
  }
  return named;
}

}  // namespace fluxgs::gl
