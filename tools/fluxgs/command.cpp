#include "tools/fluxgs/command.h"

#include <cstdio>
#include <span>

#include <fmt/format.h>

#include "fluxgs/io/file.h"

namespace fluxgs::cli {

CLI::Option* add_background(CLI::App& command, std::vector<double>& background) {
  const auto in_range = [](const std::string& text) {  // CLI::Range lets NaN through
    double value = -1;
    const bool number = CLI::detail::lexical_cast(text, value);
    return number && value >= 0 && value <= 1 ? std::string()
                                              : text + " is not a number from 0 to 1";
  };
  return command.add_option("--background", background, "colour behind the scene, r,g,b in 0..1")
      ->delimiter(',')
      ->expected(3)
      ->check(CLI::Validator(in_range, "0..1"));
}

void print_json(const nlohmann::json& object) { fmt::print("{}\n", object.dump(2)); }

Expected<void> write_json(const std::string& path, const nlohmann::json& object) {
  const std::string text = object.dump(2) + "\n";
  return write_file_atomic(path, std::as_bytes(std::span(text)));
}

}  // namespace fluxgs::cli
