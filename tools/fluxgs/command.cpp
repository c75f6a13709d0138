#include "tools/fluxgs/command.h"

#include <cstdio>
#include <span>

#include <fmt/format.h>

#include "fluxgs/io/file.h"

namespace fluxgs::cli {

void print_json(const nlohmann::json& object) { fmt::print("{}\n", object.dump(2)); }

Expected<void> write_json(const std::string& path, const nlohmann::json& object) {
  const std::string text = object.dump(2) + "\n";
  return write_file_atomic(path, std::as_bytes(std::span(text)));
}

}  // namespace fluxgs::cli
