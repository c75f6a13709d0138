// Warnings about poses of a data set: coordinates that are too large for single precision or too
// small for the renderer's near plane, and cameras that look past the sparse points.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "trainer/data/dataset.h"

namespace fluxgs {

/// Scene units from a typical camera to what it sees: the median over the cameras of their median
/// depth of the sparse points in front of them; without such points, of the distance to the point
/// that the views meet in. Nothing where there is neither: cameras that look outward or the same
/// way.
std::optional<double> typical_depth(const Dataset& data);

/// One line for each that is wrong: most cameras see none of the sparse points; positions so far
/// from the origin that numbers of 32 bits round them by more than a tenth of a pixel of what is
/// seen (where cameras look the same way, of what is as far away as they are apart); a scene so
/// near its cameras, less than five times the near plane, that parts of it are not drawn.
std::vector<std::string> scale_warnings(const Dataset& data);

}  // namespace fluxgs
