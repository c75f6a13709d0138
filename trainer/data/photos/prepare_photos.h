// Copies of photos for COLMAP: upright, reduced, as JPEG.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "fluxgs/error.h"
#include "trainer/core/progress.h"
#include "trainer/data/lens.h"
#include "trainer/data/photos/photo_list.h"

namespace fluxgs {

struct PreparedPhoto {
  Photo photo;
  std::string copy;     ///< name of the copy below the folder of copies; without spaces
  ImageSize size;       ///< of the copy
  int orientation = 1;  ///< Exif's: how the photo is turned before it is the copy
  double focal = 0;     ///< pixels of the copy; 0: not known
  std::string camera;   ///< the same for photos that one lens at one focal length took, both sides
                        ///< of a turned phone apart
  std::optional<glm::dvec3> position;  ///< GPS, as in Exif
};

/// Makes those copies that `folder` does not have. Photos that cannot be read are left out, with
/// one warning; an error where half of them or all but one fail, or a copy cannot be written.
Expected<std::vector<PreparedPhoto>> prepare_photos(const std::vector<Photo>& photos,
                                                    const std::filesystem::path& folder,
                                                    const StepReport& report,
                                                    std::vector<std::string>& warnings);

/// The copy's name for a photo's.
std::string copy_name(const std::string& name);

}  // namespace fluxgs
