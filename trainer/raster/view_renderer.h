// Renderers as functions of a camera, for measuring scenes.
#pragma once

#include <functional>

#include "fluxgs/camera.h"
#include "fluxgs/error.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/core/parallel.h"
#include "trainer/core/planar_image.h"

namespace fluxgs {

/// Renders a camera's view: 3 channels, 0…1 (limited to that range when scored).
using ViewRenderer = std::function<Expected<PlanarImage>(const Camera&)>;

/// The trainer's own renderer for `cloud`. Copies what it needs of the cloud. It has no way to
/// fail.
ViewRenderer cpu_view_renderer(const SplatCloud& cloud, const RenderOptions& options,
                               const Threads& threads);

}  // namespace fluxgs
