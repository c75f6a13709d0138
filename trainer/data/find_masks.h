// Finds the masks that lie beside the photos of a data set.
#pragma once

#include <filesystem>

#include "trainer/data/source.h"

namespace fluxgs {

/// Gives every frame without a mask the one in the folder masks/ or mask/ (in any case) of the data
/// set, or of its images/, that has its name below images/ or below the data set: photo.jpg.png, as
/// COLMAP names it, or photo.png, in any case and with any extension of an image. A warning where
/// there are masks and no frame has one.
void find_masks(Source& source, const std::filesystem::path& folder);

}  // namespace fluxgs
