// A COLMAP model with its images, as a data set.
#pragma once

#include <filesystem>
#include <vector>

#include "fluxgs/error.h"
#include "trainer/data/source.h"

namespace fluxgs {

/// Read the model in `model_folder` whose images have names relative to one of `image_folders`.
/// Images without a file, or without one of their own, are skipped and counted. Errors: those of
/// read_colmap_model; images listed twice or of unknown cameras.
Expected<Source> read_colmap_source(const std::filesystem::path& model_folder,
                                    const std::vector<std::filesystem::path>& image_folders);

}  // namespace fluxgs
