// Reading of files and their beginnings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs {

/// True if a path names a regular file that exists; false, too, for names no file can have.
bool is_file(const std::filesystem::path& path);

/// The content of a file as text, without a byte order mark. Errors: those of read_file(); UTF-16.
Expected<std::string> read_text(const std::filesystem::path& file,
                                std::uint64_t max_bytes = UINT64_MAX);

/// At most `count` bytes from the beginning of a regular file.
Expected<std::vector<std::byte>> read_prefix(const std::filesystem::path& file, std::size_t count);

}  // namespace fluxgs
