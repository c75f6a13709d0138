// A photo with what masks and transparency say of its pixels.
#pragma once

#include <cstdint>

#include "fluxgs/error.h"
#include "fluxgs/image.h"
#include "trainer/data/dataset.h"
#include "trainer/data/source.h"

namespace fluxgs {

/// All of one size; as in View.
struct Layers {
  Image<std::uint8_t> rgb, used, alpha;
};

/// Decodes a frame's photo and mask, turns both upright and composites the photo on the background.
/// The size is that of the frame's lens.
/// Masks: white counts, black is masked, grey from 128 on counts; of colours the brightest channel
/// is taken, times alpha; values of 0 and 1 alone are black and white. A mask of another size is
/// resized, and turned where it lies as the photo does not.
/// Errors: those of read_image(), a photo or mask that has not the shape of the lens.
Expected<Layers> read_layers(const SourceFrame& frame, const LoadOptions& options);

}  // namespace fluxgs
