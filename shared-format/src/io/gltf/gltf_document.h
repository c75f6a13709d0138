// The splats of a glTF document: where each attribute lies in its buffers and which transforms the
// nodes give it, all bounds checked. No splat data are read here.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "fluxgs/error.h"
#include "fluxgs/networks/appearance.h"
#include "fluxgs/transform.h"
#include "io/gltf/glb_container.h"
#include "io/gltf/gltf_buffers.h"
#include "io/gltf/gltf_json.h"

namespace fluxgs::io {

/// A checked accessor: element i begins at data + i·stride and lies inside the file.
struct GltfAttribute {
  const std::byte* data = nullptr;
  std::size_t stride = 0;  ///< 0: all elements are the first one
  std::size_t count = 0;
  int component_type = 0;  ///< TINYGLTF_COMPONENT_TYPE_…
  bool normalized = false;
  std::shared_ptr<const std::vector<std::byte>> owned = {};  ///< the data of a sparse accessor
};

/// The smallest and the largest position that an accessor states.
struct GltfBounds {
  glm::dvec3 least{0.0}, most{0.0};
};

/// Compression of a primitive's splats.
enum class GltfCompression { none, spz, compact };

/// Networks of compact splats (networks/appearance.h), as they lie in the file.
struct GltfNetworks {
  GltfView psi, phi;  ///< empty: none
  networks::Normalisation normalisation;
};

/// One splat primitive: either attributes or compressed splats.
struct GltfSplats {
  std::size_t count = 0;
  int sh_degree = 0;
  bool linear_colours = false;  ///< linear instead of sRGB-encoded
  GltfAttribute position, rotation, scale, opacity;
  std::array<GltfAttribute, 16> sh;  ///< degree 0, then 1…sh_degree in the order of the basis

  GltfCompression compression = GltfCompression::none;
  GltfView compressed;                   ///< instead of the attributes
  std::string compressed_field;          ///< names them in errors
  std::optional<GltfBounds> bounds;      ///< of compressed positions, if stated
  std::optional<GltfNetworks> networks;  ///< of compact splats
  std::size_t chunk = 0;                 ///< of compact splats: its number, by importance
  int version = kCompactVersion;         ///< of compact splats
};

/// One splat primitive under one node.
struct GltfInstance {
  GltfSplats splats;
  AffineMap transform;  ///< the node's, global; finite, and does not flatten
};

/// A document from a stranger, checked.
struct GltfDocument {
  GltfJson json;
  GlbChunks chunks;                  ///< of a .glb
  std::vector<std::byte> json_room;  ///< what they and the buffers may point into
  GltfBuffers buffers;               ///< what the instances point into
  /// All splat primitives of the default scene, in the order of its nodes.
  std::vector<GltfInstance> instances;
  std::vector<std::string> warnings;  ///< see SceneFile::warnings
};

/// Opens a .glb or the text of a .gltf. `files` reads what lies beside it; empty: nothing does. Of
/// a .glb with compact splats only the JSON is read. `file` must outlive the document.
Expected<GltfDocument> open_gltf(const ByteSource& file, NamedFiles files, const std::string& name);

}  // namespace fluxgs::io
