// ZIP archives written into memory, through libzip.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs::io {

/// An archive with these files, name and content, in this order: stored, as their content is
/// compressed, with a fixed date. The same files always give the same bytes.
Expected<std::vector<std::byte>> write_zip(
    std::span<const std::pair<std::string, std::vector<std::byte>>> files, const std::string& name);

}  // namespace fluxgs::io
