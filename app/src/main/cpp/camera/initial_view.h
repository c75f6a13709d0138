// Computes the view that a scene is shown with first.
#pragma once

#include <optional>

#include "camera/navigation.h"
#include "fluxgs/io/initial_view.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs::camera {

/// A scene's own initial view, with the target where something is seen in the image's middle, and
/// its own up, wide enough for all of the photo that was taken from there (at most 100 degrees);
/// otherwise all of the scene, with up_of_cloud(). `size` of the image, pixels.
Navigation initial_navigation(const SplatCloud& cloud, const std::optional<InitialView>& initial,
                              const glm::dvec2& size);

}  // namespace fluxgs::camera
