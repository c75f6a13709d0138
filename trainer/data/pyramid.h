// Photos at half, a quarter, … of their size.
#pragma once

#include <vector>

#include "trainer/data/dataset.h"

namespace fluxgs {

/// A photo reduced to half its size, area-averaged; odd rows and columns at the end are left out.
/// The camera is that of the remaining pixels. Its sides must be 2 or more.
Photo halved(const Photo& photo);

/// Photos at 1, ½, ¼, … of their size: `levels` + 1 lists, or fewer where a photo would be smaller
/// than `least` pixels.
class PhotoPyramid {
 public:
  PhotoPyramid(const std::vector<Photo>& photos, int levels, int least = 16);

  /// The photos at 1/2^level, or at the smallest size there is.
  const std::vector<Photo>& at(int level) const;

 private:
  const std::vector<Photo>& full_;
  std::vector<std::vector<Photo>> smaller_;
};

}  // namespace fluxgs
