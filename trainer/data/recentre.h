// Data sets far from the origin, such as those in metres of a map's grid.
#pragma once

#include "trainer/data/source.h"

namespace fluxgs {

/// Moves all poses and points near the origin, with a warning that names by how much, where numbers
/// of 32 bits, which splats have, would be wrong by more than two pixels of an image: nothing can
/// be trained there. The move is a whole multiple of a length much larger than the scene, so that a
/// few images more or less do not change it.
void recentre(Source& source);

}  // namespace fluxgs
