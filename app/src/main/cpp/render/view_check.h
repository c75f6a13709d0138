// Checks of a camera and of render options, before anything is drawn with them.
#pragma once

#include "fluxgs/camera.h"
#include "fluxgs/error.h"
#include "fluxgs/render_options.h"

namespace fluxgs::render {

/// Fails on an image without pixels.
Expected<void> check_image_size(const Camera& camera);

/// Fails, naming the field, on a camera or options that no image can be made with: sizes or
/// focal lengths that are not positive, anything not finite, cut-offs outside (0, 1], a degree
/// outside 0…3, a background outside 0…1.
Expected<void> check_view(const Camera& camera, const RenderOptions& options);

}  // namespace fluxgs::render
