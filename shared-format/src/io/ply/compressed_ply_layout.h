// Layout of the compressed .ply, the same for its reader and its writer; see compressed_ply.h.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace fluxgs::io {

inline constexpr std::size_t kChunkSplats = 256;
inline constexpr std::size_t kBounds = 12;  ///< properties of a chunk without those of the colour
inline constexpr std::array<std::string_view, 18> kChunkNames{
    "min_x",       "min_y",       "min_z",       "max_x",       "max_y",       "max_z",
    "min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z",
    "min_r",       "min_g",       "min_b",       "max_r",       "max_g",       "max_b"};
inline constexpr std::array<std::string_view, 4> kPackedNames{"packed_position", "packed_rotation",
                                                              "packed_scale", "packed_color"};

}  // namespace fluxgs::io
