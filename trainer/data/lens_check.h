// Warnings about intrinsics that hardly any camera has.
#pragma once

#include "trainer/data/source.h"

namespace fluxgs {

/// One line for each of the two: focal lengths that look like fractions of the image's width;
/// principal points in the corner or outside of the image.
void warn_of_lenses(Source& source);

}  // namespace fluxgs
