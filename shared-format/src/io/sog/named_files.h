// Formats of several files: their names come from inside one of them, that is from a stranger.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs::io {

/// The content of a file by its name, from an archive or a folder; an error if it is missing or
/// holds more than `max_bytes`.
using NamedFiles = std::function<Expected<std::vector<std::byte>>(const std::string& file,
                                                                  std::uint64_t max_bytes)>;

/// True if a name is plainly relative and stays in its folder: "a.webp", "0_0/meta.json". Not "..",
/// absolute paths, drives, URLs, backslashes or control characters.
bool is_plain_name(std::string_view file);

/// An error for a name that is not plain, with the name cut and made printable.
Error name_error(const std::string& name, const std::string& field, std::string_view file);

}  // namespace fluxgs::io
