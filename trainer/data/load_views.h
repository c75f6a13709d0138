// Loads the frames of a data set as images in memory.
#pragma once

#include <vector>

#include "fluxgs/error.h"
#include "trainer/data/dataset.h"
#include "trainer/data/photo_memory.h"
#include "trainer/data/source.h"

namespace fluxgs {

/// Decode, composite on the background, undistort and reduce every frame, in parallel; the result
/// has the order of the frames. Those for which `memory` has no room lie in files.
std::vector<Expected<View>> load_views(const std::vector<SourceFrame>& frames,
                                       const LoadOptions& options, PhotoMemory& memory);

}  // namespace fluxgs
