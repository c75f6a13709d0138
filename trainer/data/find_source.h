// Finds the images and poses of a data set, and reads or makes them.
#pragma once

#include <filesystem>
#include <string>

#include "fluxgs/error.h"
#include "trainer/data/dataset.h"
#include "trainer/data/source.h"

namespace fluxgs {

struct FoundSource {
  std::string kind;  ///< "COLMAP", the name of a transforms.json, or PhotosSource::kind
  Source source;
  std::filesystem::path folder;  ///< where masks and lists of test images may lie, too
};

/// The poses in a folder (pose_places()), or above one of photos; without any COLMAP looks for
/// them. `given` is what the user named: the folder, a .json file in it, or a video. Errors: those
/// of the readers.
Expected<FoundSource> find_source(const std::filesystem::path& folder,
                                  const std::filesystem::path& given, const LoadOptions& options);

}  // namespace fluxgs
