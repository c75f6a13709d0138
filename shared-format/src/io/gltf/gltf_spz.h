// Splats that glTF holds as SPZ: kSpzExtensionNames (drafts of Khronos).
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <glm/vec3.hpp>

#include "fluxgs/error.h"
#include "io/gltf/gltf_compressed.h"
#include "io/gltf/gltf_document.h"
#include "io/spz/spz_packed.h"

namespace fluxgs::io {

/// Check that the SPZ data in buffer view `view` and the accessors, which describe what comes out
/// of them, agree about the number of splats and, if they name harmonics, the degree. `extension`
/// names the draft in errors.
Expected<GltfSplats> find_spz_splats(const GltfCompressedPlace& place, int view,
                                     const std::string& extension);

/// The signs from the axes stored in the SPZ to those of glTF. The drafts want right-up-back turned
/// into glTF's left-up-front, and some programs do it; others, CesiumJS among them, store and show
/// the positions as they are. The bounds of POSITION, which glTF demands, tell which it was: the
/// frame that fits them better is taken, the draft's if neither does or none are given.
glm::vec3 spz_signs_in_gltf(const SpzPacked& packed, const std::optional<GltfBounds>& bounds);

}  // namespace fluxgs::io
