// Views that are kept, over the end of the process too.
#pragma once

#include <optional>

#include "camera/view_state.h"

namespace fluxgs::viewer {

struct SavedView {
  camera::ViewState view;
  glm::dvec3 up{0, -1, 0};  ///< in the scene
};

/// A saved view with directions of unit length, if it is a view at all: whoever kept it may have
/// changed it.
std::optional<SavedView> restored(SavedView saved);

}  // namespace fluxgs::viewer
