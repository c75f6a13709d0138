// The first camera of a glTF document.
#pragma once

#include <optional>

#include <nlohmann/json_fwd.hpp>

#include "fluxgs/io/initial_view.h"

namespace fluxgs::io {

/// The first perspective camera among the top nodes of the default scene. A camera says only where
/// to begin: what is odd about one (a node that shears, numbers out of range) is no error, there is
/// none then. Without `extras.up` up is glTF's.
std::optional<InitialView> find_initial_view(const nlohmann::json& document);

/// Adds one, before the others. The document must have scenes.
void add_initial_view(const InitialView& view, nlohmann::json& document);

}  // namespace fluxgs::io
