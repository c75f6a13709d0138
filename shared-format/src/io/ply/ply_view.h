// The start view of a scene in a comment of a PLY header, as InitialView has it (ours; others skip
// it):
//
//   StartView: position 1 2 3 orientation 1 0 0 0 fov_y 0.87 up 0 -1 0 image_size 640 480
//
// The orientation is w x y z; image_size is there where it is known.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "fluxgs/io/initial_view.h"

namespace fluxgs::io {

/// The view that the comments (without the word "comment") name; the last sound one counts.
std::optional<InitialView> view_of_comments(std::span<const std::string> comments);

/// The comment for a view as a line of a header; empty for none and for one that is not sound.
std::string comment_line(const std::optional<InitialView>& view);

}  // namespace fluxgs::io
