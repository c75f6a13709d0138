#include "viewer/saved_view.h"

#include <glm/geometric.hpp>

namespace fluxgs::viewer {

std::optional<SavedView> restored(SavedView saved) {
  constexpr double kMaxCoordinate = 1e12;
  camera::ViewState& view = saved.view;
  const double turn = glm::length(view.orientation), up = glm::length(saved.up);
  const bool sound = glm::length(view.target) <= kMaxCoordinate && turn > 0.5 &&
                     turn <= kMaxCoordinate && up > 0.5 && up <= kMaxCoordinate &&
                     view.distance > 0 && view.distance <= kMaxCoordinate && view.fov > 0 &&
                     view.fov < std::numbers::pi;
  if (!sound) return std::nullopt;
  view.orientation = glm::normalize(view.orientation);
  saved.up = glm::normalize(saved.up);
  return saved;
}

}  // namespace fluxgs::viewer
