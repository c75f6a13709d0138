// Splat primitives whose splats lie compressed in one bufferView: their accessors say only what
// comes out.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "fluxgs/error.h"
#include "io/gltf/gltf_document.h"

namespace tinygltf {
class Model;
struct Primitive;
}  // namespace tinygltf

namespace fluxgs::io {

/// A primitive and where it stands.
struct GltfCompressedPlace {
  const tinygltf::Model& model;
  const tinygltf::Primitive& primitive;
  GltfBuffers& buffers;
  const std::string& name;
  const std::string& field;
};

/// The highest degree of which the primitive names a coefficient.
int highest_degree(const tinygltf::Primitive& primitive);

/// The count that all attributes share, the degree that they name completely, the place of buffer
/// view `view`, and the bounds of POSITION. `extension` names the compression in errors.
Expected<GltfSplats> describe_compressed(const GltfCompressedPlace& place, int view,
                                         const char* extension);

}  // namespace fluxgs::io
