// Putting together a .glb: what goes into its BIN chunk is announced first, then written.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "fluxgs/error.h"

namespace fluxgs::io {

/// glTF 2.0, sections 5.1 and 5.11.
inline constexpr int kGltfByte = 5120, kGltfUnsignedByte = 5121, kGltfShort = 5122,
                     kGltfUnsignedShort = 5123, kGltfFloat = 5126, kGltfArrayBuffer = 34962;

/// A POINTS primitive of splats: semantic → accessor, and the extensions and extras of
/// KHR_gaussian_splatting's object (null: none).
struct GltfPrimitive {
  nlohmann::json attributes;
  nlohmann::json nested = {};
  nlohmann::json extras = {};
};

/// A mesh and the even scale of the node that shows it.
struct GltfMesh {
  std::vector<GltfPrimitive> primitives;
  double scale = 1;
};

/// The lists of a document with meshes of splats, as far as they are known.
class GltfBuilder {
 public:
  /// Announces a part of the BIN chunk, which begins at bin_bytes(), a multiple of 4. Returns its
  /// bufferView. Of vertices, `stride` is from one to the next; 0: they are close together.
  std::size_t add_view(std::size_t bytes, bool vertices, std::size_t stride = 0);
  /// Returns its index.
  std::size_t add_accessor(nlohmann::json accessor);

  std::size_t bin_bytes() const { return bin_bytes_; }

  /// The whole document: one scene, a node for each mesh. All primitives have the same extensions
  /// nested. Those are listed as used and, if `required`, as required.
  nlohmann::json document(const std::vector<GltfMesh>& meshes, bool required) const;

 private:
  nlohmann::json accessors_ = nlohmann::json::array(), views_ = nlohmann::json::array();
  std::size_t bin_bytes_ = 0;
};

/// The document of a scene without splats, which glTF has no accessors for.
nlohmann::json empty_gltf_document();

/// A framed file whose BIN chunk, still zeros, begins at `bin`.
struct GlbOutput {
  std::vector<std::byte> bytes;
  std::size_t bin = 0;
};

/// An error if the file would exceed the 4 GiB that a .glb can hold. No BIN chunk for 0 bytes.
Expected<GlbOutput> allocate_glb(const nlohmann::json& document, std::size_t bin_bytes,
                                 const std::string& name);

}  // namespace fluxgs::io
