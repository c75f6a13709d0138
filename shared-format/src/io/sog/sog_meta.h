// meta.json of a SOG scene (PlayCanvas, "The SOG Format", section 2), checked, in one shape for
// both versions of the format.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>

#include "fluxgs/error.h"
#include "fluxgs/screen_filter.h"

namespace fluxgs::io {

/// Meaning of a byte of an image: a codebook (version 2) or 256 steps of a range (version 1).
struct SogTable {
  std::array<float, 256> values{};
  std::size_t size = 256;  ///< a byte from here on is out of range
};

/// Coefficients of degrees 1 to 3: a palette, and for each splat an index into it.
struct SogSh {
  std::optional<std::size_t>
      count;                  ///< entries of the palette; without: as many as its image holds
  std::optional<int> degree;  ///< without: as the width of the palette's image says
  SogTable table;
  std::string centroids, labels;  ///< names of images
};

struct SogMeta {
  std::size_t count = 0;
  ScreenFilter filter;
  glm::dvec3 mean_min{0}, mean_max{0};  ///< of sign(x)·ln(|x| + 1)
  std::array<std::string, 2> means;     ///< names of images: low bytes, high bytes
  std::array<SogTable, 3> scales;       ///< natural logarithms
  std::array<SogTable, 4> sh0;          ///< red, green, blue coefficient; logit of the opacity
  std::string scales_image, quats_image, sh0_image;
  std::optional<SogSh> sh;
};

/// Version 2, or version 1, which has no `version` and ranges instead of codebooks. `field` names
/// the text in errors. All file names are plain (see is_plain_name()), all numbers fit a float.
Expected<SogMeta> parse_sog_meta(const nlohmann::json& root, const std::string& name,
                                 const std::string& field);

}  // namespace fluxgs::io
