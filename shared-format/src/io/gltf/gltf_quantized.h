// Splats as attributes of KHR_gaussian_splatting in 8 or 16 bits, in glTF's frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <nlohmann/json.hpp>

#include "fluxgs/splat_cloud.h"
#include "io/gltf/gltf_builder.h"

namespace fluxgs::io {

/// Splats of about one size, which share a node.
struct SizeClass {
  double scale = 1;                   ///< of the node: a power of two, no scale is larger
  std::vector<std::uint32_t> splats;  ///< their indices in the cloud, ascending
};

/// All splats of a finite cloud in classes of descending sizes, none of them empty. `bits`: 8
/// or 16.
std::vector<SizeClass> size_classes(const SplatCloud& cloud, int bits);

/// Announces the attributes of a class. Returns semantic → accessor.
nlohmann::json add_quantized_attributes(const SplatCloud& cloud, const SizeClass& one, int bits,
                                        GltfBuilder& builder);

/// Writes them, from where the BIN chunk ended before they were announced. Returns their end.
std::byte* put_quantized_attributes(const SplatCloud& cloud, const SizeClass& one, int bits,
                                    std::byte* at);

}  // namespace fluxgs::io
