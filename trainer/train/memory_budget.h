// Estimate of the memory that training takes, so that splats are added only while there is room.
#pragma once

#include <cstddef>

#include "fluxgs/error.h"
#include "trainer/data/dataset.h"
#include "trainer/model/options.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {

/// Splat–tile pairs of a visible splat, before anything was measured.
inline constexpr double kDefaultPairs = 12;

/// Splat–tile pairs of a visible splat; 0 of few splats, whose mean would say nothing.
double pairs_per_splat(const RasterCounts& counts);

/// Upper bound in bytes, the program's own included: images, planes of the largest image, and for
/// each splat its parameters, moments and gradients, one more copy while splats are rearranged,
/// `pairs` (mean splat–tile pairs of the visible splats), and the weights of all views that
/// some phases need.
std::size_t training_memory(const Dataset& data, const TrainOptions& options, std::size_t splats,
                            double pairs);

/// The most splats for which that is at most `max_memory`; without such a limit, the most there
/// are.
std::size_t splats_in_memory(const Dataset& data, const TrainOptions& options, double pairs);

/// An error if there is no room for a thousand splats, which names what the images take.
Expected<void> check_memory(const Dataset& data, const TrainOptions& options);

}  // namespace fluxgs
