// Estimate of the memory that opening a scene takes, from the header of its file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "fluxgs/error.h"

namespace fluxgs {

/// Size of a scene as its file announces it.
struct SceneEstimate {
  std::string format;         ///< see scene_formats()
  std::uint64_t splats = 0;   ///< as the file announces; 0 where only decoding tells
  int sh_degree = 0;          ///< the highest
  std::uint64_t decoded = 0;  ///< bytes of the SplatCloud
};

/// Looks at headers only. What is damaged further on is seen when the scene is read. Fails, as
/// read_scene() does, on what is no scene at all.
Expected<SceneEstimate> estimate_scene(std::span<const std::byte> bytes, const std::string& name);

/// Size of a file that nobody tells.
inline constexpr std::uint64_t kUnknownSize = ~std::uint64_t{0};

/// The same of the first bytes of a file, of which there are `size`, or kUnknownSize. Nothing for
/// formats that announce nothing at their beginning (.glb, .sog).
std::optional<SceneEstimate> estimate_beginning(std::span<const std::byte> begin,
                                                std::uint64_t size, const std::string& name);

}  // namespace fluxgs
