// Fits the cameras of a data set to the images that are there.
#pragma once

#include "trainer/data/source.h"

namespace fluxgs {

/// Reads the header of every frame's image, training and test, and scales the lens to its size. An
/// image that fits its camera only after it is turned as its EXIF orientation says is turned when
/// it is loaded; all others stay as they are stored, as COLMAP takes them. Left out, with one
/// warning for each kind: files that are no images, and images whose sides are those of their
/// camera swapped.
void fit_to_images(Source& source);

}  // namespace fluxgs
