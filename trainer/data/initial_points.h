// Where the first splats go.
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
  std::string source;                ///< "sparse points", "triangulated features" or "random"
};

/// The data set's sparse points; without any, image features triangulated from the training images'
/// known poses; where fewer than 500 of those are found, random points in the cameras' frustums.
/// Deterministic for a seed, whatever the number of threads. Errors: no training images.
Expected<PointCloud> initial_points(const Dataset& dataset, std::uint64_t seed,
                                    const Threads& threads, const ProgressReport& progress = {});

}  // namespace fluxgs
