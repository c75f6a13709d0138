// The start view that scenes are written with (fluxgs/io/start_view.h).
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "fluxgs/io/start_view.h"
#include "trainer/data/dataset.h"

namespace fluxgs::cli {

/// That of the image in the middle of the others, with the up of all. `views` has at least one.
StartView start_view_of(const std::vector<View>& views);

/// Writes a .glb under its name, with a start view if there is one. Returns the bytes of the file.
Expected<std::size_t> write_glb(const std::filesystem::path& path,
                                const std::vector<std::byte>& glb,
                                const std::optional<StartView>& start);

}  // namespace fluxgs::cli
