// A scene as blocks of memory, so that it can go from one instance of the module to another.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <type_traits>
#include <utility>

#include "viewer/budgeted_reading.h"

namespace fluxgs::web {

/// All of a LoadedScene but its arrays.
struct SceneHead {
  std::size_t count = 0;  ///< splats
  int sh_degree = 0;
  std::size_t file_splats = 0;
  int file_sh_degree = 0;
  ScreenFilter filter;
  std::size_t dropped = 0;
  std::optional<InitialView> start;
  bool is_coarse = false;
};
static_assert(std::is_trivially_copyable_v<SceneHead>);

struct Block {
  void* data = nullptr;
  std::size_t bytes = 0;
};
inline constexpr std::size_t kBlocks = 6;

SceneHead head_of(const viewer::LoadedScene& scene);
/// A scene with room for what its head says.
viewer::LoadedScene scene_with(const SceneHead& head);
/// The arrays of a scene.
std::array<Block, kBlocks> blocks_of(viewer::LoadedScene& scene);

}  // namespace fluxgs::web
