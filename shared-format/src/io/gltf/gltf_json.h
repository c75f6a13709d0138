// The JSON of a .glb from a stranger: checked, and cut down to the parts that splats need, before a
// glTF library sees it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/io/initial_view.h"

namespace fluxgs::io {

inline constexpr char kSplatExtension[] = "KHR_gaussian_splatting";
inline constexpr char kSpzExtension[] = "KHR_gaussian_splatting_compression_spz_2";
inline constexpr char kCompactExtension[] = "FLUXGS_gaussian_splatting_compact";
/// And where it keeps the compact extension's networks: "psi" and "phi" (bufferViews) and
/// "normalisation".
inline constexpr char kNetworks[] = "networks";
inline constexpr int kCompactVersion = 2;  ///< the only one; see schema/
/// Members in which the reduced document keeps the compression of a primitive's splats, and
/// the bufferView of their data.
inline constexpr char kCompression[] = "compression", kCompressedView[] = "compressedBufferView";

struct GltfJson {
  /// A glTF document of bufferViews, accessors, meshes, nodes and scenes under their old indices:
  /// no URIs, images, materials, foreign extensions or extras, and all its numbers are of the kinds
  /// that the specification wants. A nested kSpzExtension or
  /// kCompactExtension becomes the members kCompression and kCompressedView.
  std::string reduced;
  std::vector<std::string> extensions_used;
  std::size_t buffer_bytes = 0;      ///< length of buffer 0, at most that of the BIN chunk
  std::optional<InitialView> start;  ///< see gltf_camera.h
};

/// Parse and check. Bounds: 16 MiB of text, 64 levels, 65,536 entries in each list, 65,536
/// primitives in all meshes.
Expected<GltfJson> check_gltf_json(std::string_view text, std::size_t bin_bytes,
                                   const std::string& name);

}  // namespace fluxgs::io
