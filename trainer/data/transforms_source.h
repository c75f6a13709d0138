// transforms.json as instant-ngp, nerfstudio and the NeRF-synthetic set write it.
#pragma once

#include <filesystem>
#include <vector>

#include "fluxgs/error.h"
#include "trainer/data/source.h"

namespace fluxgs {

/// Read a transforms.json, with the transforms_test.json beside it as the test frames if it is
/// called transforms_train.json. Poses are camera → world with OpenGL axes (x right, y up, z
/// backward); the world stays as it is, a uniform scale in a pose's rotation is dropped. Paths of
/// images are relative to one of `image_folders`.
/// Intrinsics for another resolution are scaled to the image files' real size, x and y each.
/// Frames without an image file are skipped and counted.
Expected<Source> read_transforms_source(const std::filesystem::path& file,
                                        const std::vector<std::filesystem::path>& image_folders);

/// The file to read in a folder: transforms_train.json if it exists, or else transforms.json.
std::filesystem::path transforms_file(const std::filesystem::path& folder);

/// True if that file exists.
bool has_transforms(const std::filesystem::path& folder);

}  // namespace fluxgs
