// Writes a .glb with its initial view.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/io/initial_view.h"

namespace fluxgs::cli {

/// Writes a .glb under its name, with an initial view if there is one. Returns the bytes of the
/// file.
Expected<std::size_t> write_glb(const std::filesystem::path& path,
                                const std::vector<std::byte>& glb,
                                const std::optional<InitialView>& initial);

}  // namespace fluxgs::cli
