// A price on opacity and size, so that splats that images do without fade away (Kheradmand et al.
// 2024, section 3.5).
#pragma once

#include <cstdint>
#include <vector>

#include "trainer/core/parallel.h"
#include "trainer/core/parameters.h"
#include "trainer/model/options.h"

namespace fluxgs {

bool has_penalties(const TrainOptions& options);

/// Adds the derivatives of opacity_weight × mean opacity + scale_weight × mean standard deviation
/// to the gradients of visible splats.
void add_penalties(const PlanarFloats& parameters, const std::vector<std::uint8_t>& visible,
                   const TrainOptions& options, PlanarFloats& gradient, const Threads& threads);

}  // namespace fluxgs
