// The 3D Gaussian splatting .ply of INRIA's reference implementation (Kerbl et al. 2023; PLY: Turk,
// "The PLY Polygon File Format", 1994). The compressed kind is in compressed_ply.h.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fluxgs/byte_source.h"
#include "fluxgs/error.h"
#include "fluxgs/io/scene_file.h"
#include "fluxgs/io/splat_sink.h"

namespace fluxgs {

/// True if the bytes begin like a PLY file.
bool is_ply(std::span<const std::byte> bytes);

/// Read a scene: ASCII, little- or big-endian; properties of element `vertex` found by name, in any
/// order and of any scalar type; other properties and elements are skipped. 0, 9, 24 or 45
/// properties f_rest_* (channel-major) give the degree. Infinite logits of opacity, which other
/// programs write for opacities of 0 and 1, become the finite ones that read_glb gives these. All
/// counts are checked against the size of `bytes` before anything is allocated. `name` appears in
/// errors.
Expected<SceneFile> read_ply(std::span<const std::byte> bytes, const std::string& name);
/// The same of a file that need not be in memory. The splats go to the sink, not into the result.
Expected<SceneFile> read_ply(const ByteSource& source, const std::string& name, SplatSink& sink);

/// Write little-endian floats in INRIA's order (with zero normals): a finite scene comes back bit
/// for bit. Splats with a NaN or infinity are left out. A start view becomes a comment.
Expected<std::vector<std::byte>> encode_ply(const SplatCloud& cloud, const std::string& name,
                                            const std::optional<InitialView>& start = {});

}  // namespace fluxgs
