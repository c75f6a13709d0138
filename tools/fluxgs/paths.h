// Where files lie, whatever they are called.
#pragma once

#include <filesystem>

namespace fluxgs::cli {

/// Whether a path leads to a folder or anywhere inside of it, existing or not.
bool lies_in(const std::filesystem::path& inner, const std::filesystem::path& folder);

/// Whether two names, neither empty, are of one file, existing or not.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace fluxgs::cli
