// Splats as the plain float attributes of KHR_gaussian_splatting, in glTF's frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "fluxgs/splat_cloud.h"
#include "io/gltf/gltf_builder.h"

namespace fluxgs::io {

/// Semantic → type ("VEC3", …) of all attributes of a degree that the extension asks for.
std::vector<std::pair<std::string, const char*>> splat_semantics(int sh_degree);

/// "min" and "max" of POSITION, which glTF demands; floats become doubles without loss.
std::array<nlohmann::json, 2> gltf_bounds(const SplatCloud& cloud);

/// One splat's COLOR_0: linear, opacity last.
std::array<std::uint8_t, 4> fallback_colour(const glm::vec3& sh_dc, float opacity_logit);

/// Announces them one after the other, and behind POSITION COLOR_0 (linear, 8 bits) for viewers
/// that do not know the extension. Returns semantic → accessor.
nlohmann::json add_plain_attributes(const SplatCloud& cloud, GltfBuilder& builder);

/// Writes them, from where the BIN chunk ended before they were announced. Returns their end.
std::byte* put_plain_attributes(const SplatCloud& cloud, std::byte* at);

}  // namespace fluxgs::io
