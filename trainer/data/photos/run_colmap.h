// Poses for photos that have none, by COLMAP.
#pragma once

#include <filesystem>
#include <vector>

#include "fluxgs/error.h"
#include "trainer/core/progress.h"
#include "trainer/data/photos/colmap_state.h"
#include "trainer/data/photos/prepare_photos.h"

namespace fluxgs {

/// Extracts features, compares the photos' pairs and finds their poses, all in `work`, whose
/// images/ holds the copies. On success the models are in `work`/sparse. What an earlier,
/// interrupted run has done is kept, features photo by photo and matches some seconds at a time,
/// and so is what was done before photos were added; only the poses are then found anew. `state` is
/// that of `work`, and is kept up to date there. Photos of one camera share its lens; focal lengths
/// of Exif are where the search for it begins. COLMAP's GPU code is used where has_gpu() says so,
/// and the CPU where that fails. Errors, in one line with the log's path: COLMAP is missing, a
/// command of it failed, or it found no poses, and the likely reason.
Expected<void> run_colmap(const std::vector<PreparedPhoto>& photos,
                          const std::filesystem::path& work, ColmapState& state,
                          const StepReport& report);

}  // namespace fluxgs
