// Initial points of a training: sparse points, triangulated features or random points.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "fluxgs/error.h"
#include "trainer/core/parallel.h"
#include "trainer/data/dataset.h"

namespace fluxgs {

struct PointCloud {
  std::vector<glm::vec3> positions;  ///< world, finite
  std::vector<glm::vec3> colors;     ///< sRGB as stored, 0…1, one per position
  std::string source;  ///< "sparse points", "triangulated features" or "random"; and why
};

/// The data set's sparse points; with fewer than 50, image features triangulated from the training
/// images' known poses; where fewer than 500 of those are found, random points in the cameras'
/// frustums. Deterministic for a seed, whatever the number of threads. Errors: no training images.
Expected<PointCloud> initial_points(const Dataset& dataset, std::uint64_t seed,
                                    const Threads& threads, const ProgressReport& progress = {});

/// Points in the view of training images: a random image, a random pixel of it, and a depth uniform
/// between 0.4 and 2 times the image's focus distance (see scene_focus.h), where at least a third
/// as many images look as at the median of such points. All are mid-grey, as in 3DGS. The same for
/// the same seed on every platform.
PointCloud random_points(const std::vector<View>& views, std::size_t count, std::uint64_t seed);

}  // namespace fluxgs
