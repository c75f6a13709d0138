// The screen filter in comments of a PLY header, where trainers leave it:
//
//   SplatRenderMode: mip | default | 2dgs   Brush, gsplat, nerfstudio, splat-transform; ours
//   antialiased 1 | 0                       Postshot
//   train_flags antialiasing                proposed for INRIA's trainer
//   ScreenFilterDilation: 0.1               ours, px², where it is not 0.3
#pragma once

#include <span>
#include <string>
#include <vector>

#include "fluxgs/screen_filter.h"

namespace fluxgs::io {

/// The filter that the comments (without the word "comment") name; the last one counts, cases and
/// blanks do not. Brush compensates for a dilation of 0.1 px², the others for 0.3.
ScreenFilter filter_of_comments(std::span<const std::string> comments);

/// The comments for a filter: none for that of classic 3DGS.
std::vector<std::string> comments_of_filter(const ScreenFilter& filter);

/// The same as lines of a header.
std::string comment_lines(const ScreenFilter& filter);

}  // namespace fluxgs::io
