// glTF accessors (specification, section 3.6.2), checked against the bytes they claim.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "fluxgs/error.h"
#include "io/gltf/gltf_buffers.h"
#include "io/gltf/gltf_document.h"

namespace tinygltf {
class Model;
}

namespace fluxgs::io {

/// The component types that an attribute may have, as bits.
enum GltfComponents : unsigned {
  kFloat = 1,
  kSignedNormalized = 2,    ///< signed byte, short; normalised
  kSigned = 4,              ///< signed byte, short
  kUnsignedNormalized = 8,  ///< unsigned byte, short; normalised
  kUnsigned = 16            ///< unsigned byte, short
};

/// Requirements of the specification on one attribute.
struct GltfExpectation {
  const char* semantic;
  int type;             ///< TINYGLTF_TYPE_…
  unsigned components;  ///< GltfComponents
};

/// A buffer view, checked; of a BIN chunk nothing is read.
Expected<GltfView> find_view(const tinygltf::Model& model, int index, GltfBuffers& buffers,
                             const std::string& name);

/// The bytes of a buffer view.
Expected<std::span<const std::byte>> resolve_view(const tinygltf::Model& model, int index,
                                                  GltfBuffers& buffers, const std::string& name);

/// An error unless there is such an accessor, of the type that is expected. `field` names the
/// primitive in errors.
Expected<void> check_accessor(const tinygltf::Model& model, int accessor,
                              const GltfExpectation& expected, const std::string& name,
                              const std::string& field);

/// Resolve an accessor of `model` into memory, checked as above. Without a bufferView all elements
/// are zeros. A sparse one is unfolded into memory of its own, which is added to `sparse_bytes`; an
/// error if that becomes more than 64 times the bytes of the buffers.
Expected<GltfAttribute> resolve_accessor(const tinygltf::Model& model, int accessor,
                                         const GltfExpectation& expected, GltfBuffers& buffers,
                                         std::size_t& sparse_bytes, const std::string& name,
                                         const std::string& field);

}  // namespace fluxgs::io
