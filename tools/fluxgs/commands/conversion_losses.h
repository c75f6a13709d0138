// Words about what a scene lost when it was written in another format, by reading it again.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/io/scene_file.h"

namespace fluxgs::cli {

/// Parts of `scene` that `written` lacks, one sentence each: screen filter, start view, splats.
std::vector<std::string> lost_parts(const SceneFile& scene, const SceneFile& written);

struct RoundingErrors {
  std::string text;             ///< "rounded, at most: positions 0.0001, shapes 3 %, ..."; or empty
  std::size_t lost_shapes = 0;  ///< splats whose size is another, by more than itself
};

/// The largest errors of each attribute; the text is empty if they are those of floats. `order[k]`
/// is the splat of `scene` that is splat k of `written`; empty: the same. Splats that turn out to
/// be in another order are not compared: the text says so.
RoundingErrors rounding_errors(const SceneFile& scene, const SceneFile& written,
                               std::span<const std::uint32_t> order);

}  // namespace fluxgs::cli
