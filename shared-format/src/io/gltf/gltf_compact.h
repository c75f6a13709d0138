// Splats that a .glb holds by FLUXGS_gaussian_splatting_compact (schema/README.md).
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fluxgs/error.h"
#include "io/gltf/gltf_compressed.h"
#include "io/gltf/gltf_document.h"

namespace tinygltf {
class Value;
}

namespace fluxgs::io {

/// Places of the splats and their networks, given the reduced extension (gltf_json.h). An error if
/// the bytes may not hold as many splats as the accessors say (codec/compact.h), or if there are
/// networks and the degree is not 1.
Expected<GltfSplats> find_compact_splats(const GltfCompressedPlace& place,
                                         const tinygltf::Value& extension);

/// Bytes of a primitive's splats and their networks.
struct CompactBytes {
  std::span<const std::byte> stream, psi, phi;  ///< empty: there is none
};

/// Decodes them, in glTF's frame, their networks baked in. Errors name the file and the primitive.
Expected<SplatCloud> decode_compact_splats(const GltfSplats& from, const CompactBytes& bytes,
                                           const std::string& name);

/// Bytes that each attribute takes. Nothing if the stream is damaged.
std::vector<std::pair<std::string, std::size_t>> compact_attribute_bytes(const GltfSplats& from,
                                                                         const CompactBytes& bytes);

}  // namespace fluxgs::io
