// Mask pruning: splats that photos show where a mask ignores them, and nowhere else, are removed.
// No loss ever touches them, so that they would stay as what they happen to be.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "trainer/core/parallel.h"
#include "trainer/data/dataset.h"
#include "trainer/densify/density_control.h"
#include "trainer/model/phase.h"

namespace fluxgs {

/// A splat is kept if at least this share of its α·T in all views lies in pixels that count.
inline constexpr double kLeastCounted = 1e-3;

/// An action for each splat: prune for those that add to ignored pixels of the views and
/// less than kLeastCounted of it to others, otherwise keep, also where no view sees a splat.
std::vector<RefineAction> masked_splats(const std::vector<View>& views,
                                        const PlanarFloats& parameters, const RenderOptions& render,
                                        Rasterizer& rasterizer);

/// Null where no view has ignored pixels.
std::unique_ptr<Phase> make_mask_pruning(const TrainOptions& options,
                                         const std::vector<View>& views);

}  // namespace fluxgs
