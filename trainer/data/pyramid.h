// Images at half, a quarter, … of their size.
#pragma once

#include <vector>

#include "trainer/data/dataset.h"

namespace fluxgs {

/// An image reduced to half its size, area-averaged; odd rows and columns at the end are left out.
/// The camera is that of the remaining pixels. Its sides must be 2 or more.
View halved(const View& view);

/// Images at 1, ½, ¼, … of their size: `levels` + 1 lists, or fewer where an image would be smaller
/// than `least` pixels.
class ViewPyramid {
 public:
  ViewPyramid(const std::vector<View>& views, int levels, int least = 16);

  /// The images at 1/2^level, or at the smallest size there is.
  const std::vector<View>& at(int level) const;

 private:
  const std::vector<View>& full_;
  std::vector<std::vector<View>> smaller_;
};

}  // namespace fluxgs
