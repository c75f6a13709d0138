// The reduction of images before training.
#pragma once

#include "fluxgs/error.h"
#include "trainer/data/lens.h"
#include "trainer/data/source.h"

namespace fluxgs {

/// Pixels of the longer side that images are reduced to unless a factor is given, as in 3DGS.
inline constexpr int kDefaultLongestSide = 1600;

/// The size of a reduced image: each side divided by the factor and rounded down, or for factor 0
/// (automatic) both sides scaled until the longer is at most kDefaultLongestSide.
ImageSize reduced_size(ImageSize stored, int factor);

/// Leaves out the images of which a factor above 1 leaves fewer than 32 pixels on the shorter side,
/// with a warning. Errors: half of the images are such; the largest factor that fits is named.
Expected<void> remove_too_small(Source& source, int factor);

}  // namespace fluxgs
