// Depth-ordered lists of projected splats for each tile.
#pragma once

#include <cstdint>
#include <vector>

#include "trainer/core/parallel.h"
#include "trainer/raster/cpu/raster_kernels.h"

namespace fluxgs {

/// Every tile's splats, nearest first, and for the backward pass the way back from pairs to splats.
struct TileLists {
  int tiles_x = 0, tiles_y = 0;
  std::vector<std::uint32_t> order;        ///< visible splats, nearest first; ties by index
  std::vector<std::uint32_t> first_slot;   ///< [order.size() + 1]: slots of each splat's pairs
  std::vector<TileEntry> entries;          ///< grouped by tile, in depth order within each
  std::vector<std::uint32_t> first_entry;  ///< [tiles + 1]

  std::size_t tiles() const {
    return static_cast<std::size_t>(tiles_x) * static_cast<std::size_t>(tiles_y);
  }
};

/// Fills lists.order from the visible splats.
void sort_by_depth(const std::vector<ProjectedSplat>& splats,
                   const std::vector<std::uint8_t>& visible, TileLists& lists);

/// Fills the rest. The result does not depend on the number of threads.
class Binner {
 public:
  void run(const Threads& threads, const RasterKernels& kernels,
           const std::vector<ProjectedSplat>& splats, const RasterConstants& constants, int width,
           int height, TileLists& lists);

 private:
  /// A run of splats in depth order, with the tiles each reaches.
  struct Chunk {
    std::vector<TileBin> bins;
    std::size_t used = 0;
    std::vector<std::uint32_t> next;  // per tile: count, then the next entry to fill
  };
  void list_tiles(const RasterKernels& kernels, const std::vector<ProjectedSplat>& splats,
                  const RasterConstants& constants, TileLists& lists, std::size_t begin,
                  std::size_t end, Chunk& chunk);
  void place_chunks(TileLists& lists);
  static void fill(TileLists& lists, std::uint32_t first_slot, Chunk& chunk);

  std::vector<Chunk> chunks_;
};

}  // namespace fluxgs
