// Sorting beside the drawing: on a thread, or wherever else a platform can.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "sort/sorter.h"

namespace fluxgs::sort {

/// An order of the splats, and the view that it belongs to.
struct IndexBuffer {
  std::vector<std::uint32_t> indices;  ///< as many as the scene has splats
  std::uint32_t count = 0;             ///< of valid ones
  std::uint64_t ticket = 0;            ///< the number of the request
};

/// Holding one keeps it from being overwritten.
using SharedIndices = std::shared_ptr<const IndexBuffer>;

/// Sorts the splats of one scene by depth, always for the newest view that was asked for.
class BackgroundSort {
 public:
  BackgroundSort() = default;
  BackgroundSort(const BackgroundSort&) = delete;
  BackgroundSort& operator=(const BackgroundSort&) = delete;
  virtual ~BackgroundSort() = default;

  /// Asks for the order of a view; one that waits to be begun is forgotten. Returns its ticket,
  /// from 1 on.
  virtual std::uint64_t request(const SortView& view) = 0;

  /// The newest order that is finished; null as long as there is none.
  virtual SharedIndices newest() = 0;

  /// Waits until the order of that ticket, or of a later one, is finished. Where waiting is not
  /// possible: the newest, or null.
  virtual SharedIndices wait(std::uint64_t ticket) = 0;
};

/// Makes one for a scene, see DepthSort on the positions.
using MakeBackgroundSort =
    std::function<std::unique_ptr<BackgroundSort>(std::vector<glm::vec3> positions)>;

}  // namespace fluxgs::sort
