// Colours in linear light (colorSpace "lin_rec709_display"), which a SplatCloud does not have.
#pragma once

#include <cstddef>

#include "fluxgs/splat_cloud.h"

namespace fluxgs::io {

/// Makes the linear colours of the splats `begin` … `end` − 1 sRGB-encoded: of each splat the
/// harmonics nearest, over all directions, to the encoded colours. Exact for splats that look the
/// same from everywhere. Linear colours below 0 are shown as 0.
void encode_linear_colours(SplatCloud& cloud, std::size_t begin, std::size_t end);

}  // namespace fluxgs::io
