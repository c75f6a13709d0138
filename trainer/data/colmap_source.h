// A COLMAP model with its images, as a data set.
#pragma once

#include <filesystem>

#include "fluxgs/error.h"
#include "trainer/data/source.h"

namespace fluxgs {

/// Read the model in `model_folder` whose images are in `data_folder`/images or `data_folder`.
/// Images without a file are skipped and counted. Errors: those of read_colmap_model; images listed
/// twice, of unknown cameras, or with poses that are not finite.
Expected<Source> read_colmap_source(const std::filesystem::path& model_folder,
                                    const std::filesystem::path& data_folder);

}  // namespace fluxgs
