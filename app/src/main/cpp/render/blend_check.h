// A trial of a driver's blending of half floats, which it should round: browsers hide the name of
// their driver.
#pragma once

#include "gl/api.h"

namespace fluxgs::render {

/// True if many faint layers in RGBA16F come out darker than they are
/// (gl::Quirks::half_float_blending_truncates). False too where there are no such targets. Waits
/// for the GPU; leaves nothing bound.
Expected<bool> half_float_blending_truncates(gl::Api& api);

}  // namespace fluxgs::render
