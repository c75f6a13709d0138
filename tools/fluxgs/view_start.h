// Where fluxgs view begins, and which way is up.
#pragma once

#include <optional>
#include <string>

#include <glm/vec3.hpp>

#include "camera/navigation.h"
#include "fluxgs/io/scene_file.h"
#include "tools/fluxgs/views.h"
#include "trainer/data/dataset.h"

namespace fluxgs::cli {

struct ViewStart {
  camera::Navigation navigation;
  std::string up_source;  ///< where the up axis is from, for people
};

/// "x,y,z", not all 0, made a unit vector; nothing for "auto". Fails on anything else.
Expected<std::optional<glm::dvec3>> parse_up(const std::string& text);

/// A given camera; otherwise the first training image's; otherwise the scene's own start view;
/// otherwise all of the scene. Up is what is given, what the images or the scene say, or a guess
/// from the cloud.
ViewStart choose_start(const SceneFile& scene, const std::optional<Dataset>& data,
                       const std::optional<Camera>& camera, const std::optional<glm::dvec3>& up,
                       const ImageSize& size);

}  // namespace fluxgs::cli
