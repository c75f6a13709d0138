// The compressed .ply that PlayCanvas SuperSplat and splat-transform write: a binary PLY file whose
// splats are quantized within chunks of 256.
//
//   element chunk    floats min_x … max_z, min_scale_x … max_scale_z (logarithms), and in newer
//                    files min_r … max_b (colours; in older ones 0…1)
//   element vertex   uint packed_position, packed_scale: 11, 10, 11 bits from the top, each a
//                    fraction of its chunk's range;
//                    uint packed_rotation: 2 bits which of w, x, y, z is the largest, then 10 bits
//                    for each of the others, 0…1023 for −√½…√½;
//                    uint packed_color: 8 bits each of red, green, blue (fractions of the chunk's
//                    range) and opacity (0…255 for 0…1)
//   element sh       optional; uchar f_rest_* (channel-major as in a 3DGS .ply): 0 is −4, 255 is 4,
//                    v between is 8·((v + ½)/256 − ½)
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/io/scene_file.h"
#include "fluxgs/io/splat_sink.h"

namespace fluxgs {

/// True if the bytes are a PLY file with a valid header whose vertices have packed_position.
bool is_compressed_ply(std::span<const std::byte> bytes);

/// Read a scene in the order of the file, already that of a SplatCloud's frame. Properties are
/// found by name and must have the types above; there must be one chunk for every 256 vertices, its
/// bounds finite, and one row of sh for every vertex. Other elements are skipped unless they hold
/// lists. All counts are checked against the size of `bytes` before anything is allocated.
/// Opacities of 0 and 255 stay finite: logits ≈ −87.3 and 17.3. `name` appears in errors.
Expected<SceneFile> read_compressed_ply(std::span<const std::byte> bytes, const std::string& name);
/// The same, but the splats go to the sink, not into the result.
Expected<SceneFile> read_compressed_ply(std::span<const std::byte> bytes, const std::string& name,
                                        SplatSink& sink);

/// Write a scene, with ranges of colour, in an order that keeps neighbours together: the ranges of
/// the chunks are then small, and a far splat coarsens only those of its chunk. Logarithms of
/// scales are limited to ±20, SH coefficients to ±4; rotations come out as unit quaternions. Splats
/// with a NaN or infinity are left out. A start view becomes a comment. The same cloud always gives
/// the same bytes.
Expected<std::vector<std::byte>> encode_compressed_ply(
    const SplatCloud& cloud, const std::string& name, const std::optional<InitialView>& start = {});

}  // namespace fluxgs
