// Programs of this machine.
#pragma once

#include <optional>
#include <string>

namespace fluxgs::cli {

/// The first program of that name on the PATH.
std::optional<std::string> find_program(const std::string& name);

}  // namespace fluxgs::cli
