#include "tools/fluxgs/terminal/json_file.h"

#include <cmath>
#include <cstdio>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"

namespace fluxgs::cli {
namespace {

/// Names of files need not be UTF-8: what is not becomes U+FFFD.
std::string text_of(const nlohmann::json& object) {
  return object.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace

/// main() asks whether all of standard output could be written.
void print_json(const nlohmann::json& object) {
  const std::string text = text_of(object);
  static_cast<void>(std::fwrite(text.data(), 1, text.size(), stdout));
}

Expected<void> write_json(const std::string& path, const nlohmann::json& object) {
  const std::string text = text_of(object);
  return write_file_atomic(path, std::as_bytes(std::span(text)));
}

Expected<void> give_report(const std::string& path, const nlohmann::json& report,
                           const std::function<void()>& print_table) {
  if (path == "-") {
    print_json(report);
    return {};
  }
  print_table();
  return path.empty() ? Expected<void>() : write_json(path, report);
}

Expected<nlohmann::json> read_json(const std::filesystem::path& path) {
  const auto bytes = read_file(path);
  if (!bytes) return std::unexpected(bytes.error());
  const char* text = reinterpret_cast<const char*>(bytes->data());
  auto value = nlohmann::json::parse(text, text + bytes->size(), nullptr, false);
  if (value.is_discarded()) return fail(path.string(), "", "expected JSON");
  return value;
}

nlohmann::json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

}  // namespace fluxgs::cli
