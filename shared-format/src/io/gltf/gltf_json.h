// The JSON of a glTF document from a stranger: checked, and cut down to the parts that splats need,
// before a glTF library sees it.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/initial_view.h"
#include "fluxgs/screen_filter.h"
#include "io/gltf/gltf_buffers.h"

namespace fluxgs::io {

inline constexpr char kSplatExtension[] = "KHR_gaussian_splatting";
/// Splats compressed by SPZ: the last draft and those before it, which differ in names and in where
/// the extension stands.
inline constexpr char kSpzExtension[] = "KHR_gaussian_splatting_compression_spz_2";
inline constexpr std::array<std::string_view, 4> kSpzExtensionNames{
    kSpzExtension, "KHR_gaussian_splatting_compression_spz", "KHR_spz_gaussian_splats_compression",
    "KHR_spz_compression"};
using fluxgs::kCompactExtension;
/// And where it keeps the compact extension's networks: "psi" and "phi" (bufferViews) and
/// "normalisation".
inline constexpr char kNetworks[] = "networks";
/// The version that is written, and the oldest that is read; see schema/.
inline constexpr int kCompactVersion = 3, kOldestCompactVersion = 2;
inline constexpr char kVersion[] = "version";  ///< the file's
inline constexpr char kChunk[] = "chunk";      ///< its chunk's number, if it has one
/// Members in which the reduced document keeps the compression of a primitive's splats, and
/// the bufferView of their data.
inline constexpr char kCompression[] = "compression", kCompressedView[] = "compressedBufferView";
/// And what it keeps of KHR_gaussian_splatting, if the document has it.
inline constexpr char kKernel[] = "kernel", kColorSpace[] = "colorSpace";

struct GltfJson {
  /// A glTF document of bufferViews, accessors, meshes, nodes and scenes under their old indices:
  /// no URIs, images, materials, foreign extensions or extras, and all its numbers are of the kinds
  /// that the specification wants. One of kSpzExtensionNames or
  /// kCompactExtension becomes the members kCompression and kCompressedView, and the attributes of
  /// drafts ("_SCALE") get the names of the extension.
  std::string reduced;
  std::vector<std::string> extensions_used;
  std::vector<GltfBuffer> buffers;
  std::optional<InitialView> start;    ///< see gltf_camera.h
  std::optional<ScreenFilter> filter;  ///< see gltf_filter.h
  std::vector<std::string> warnings;   ///< see SceneFile::warnings
};

/// Parse and check. Bounds: 16 MiB of text, 64 levels, 65,536 entries in each list, 65,536
/// primitives in all meshes.
Expected<GltfJson> check_gltf_json(std::string_view text, const std::string& name);

}  // namespace fluxgs::io
