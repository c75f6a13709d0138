// Poses for images that have none: COLMAP, as a separate program.
#pragma once

#include <filesystem>

#include "fluxgs/error.h"

namespace fluxgs {

/// Run COLMAP's feature extraction, exhaustive matching and mapping on the CPU over the images of a
/// folder, with files and a log in `work_folder`, which is created. On success the models are in
/// `work_folder`/sparse; an interrupted or failed run leaves none there.
/// Errors: COLMAP not installed, a step that failed (named, with the log), no model found.
Expected<void> run_colmap(const std::filesystem::path& images,
                          const std::filesystem::path& work_folder);

}  // namespace fluxgs
