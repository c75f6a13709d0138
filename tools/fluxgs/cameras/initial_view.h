// Initial views: those that scenes are written with, and those that fluxgs view begins with.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "camera/navigation.h"
#include "fluxgs/io/initial_view.h"
#include "fluxgs/splat_cloud.h"
#include "tools/fluxgs/cameras/cameras.h"
#include "trainer/data/dataset.h"

namespace fluxgs::cli {

/// The view that the others lie around. `views` has at least one.
const View& middle_of(const std::vector<View>& views);

/// The view in the middle of the others, with the up axis of all. `views` has at least one.
InitialView initial_view_of(const std::vector<View>& views);

/// "x,y,z", not all 0, made a unit vector; nothing for "auto". Fails on anything else.
Expected<std::optional<glm::dvec3>> parse_up(const std::string& text);

struct InitialNavigation {
  camera::Navigation navigation;
  std::string up_source;  ///< says people where the up axis is from
};

/// Begins at a given camera; otherwise at the first training view; otherwise at the scene's own
/// initial view; otherwise where all of the scene is seen. Up is what is given, what the views or
/// the scene say, or a guess from the cloud.
InitialNavigation initial_navigation(const SplatCloud& cloud,
                                     const std::optional<InitialView>& start,
                                     const std::optional<Dataset>& data,
                                     const std::optional<Camera>& camera,
                                     const std::optional<glm::dvec3>& up, const ImageSize& size);

}  // namespace fluxgs::cli
