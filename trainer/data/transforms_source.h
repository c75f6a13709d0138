// transforms.json as instant-ngp, nerfstudio and the NeRF-synthetic set write it.
#pragma once

#include <filesystem>

#include "fluxgs/error.h"
#include "trainer/data/source.h"

namespace fluxgs {

/// Read `folder`/transforms_train.json, with transforms_test.json as the test frames if it exists,
/// or else `folder`/transforms.json. Poses are camera → world with OpenGL axes (x right, y up, z
/// backward); the world stays as it is, a uniform scale in a pose's rotation is dropped.
/// Intrinsics for another resolution are scaled to the image files' real size, x and y each.
/// Frames without an image file are skipped and counted.
Expected<Source> read_transforms_source(const std::filesystem::path& folder);

/// True if the folder holds one of these files.
bool has_transforms(const std::filesystem::path& folder);

}  // namespace fluxgs
