// FLIP, how different two images look to people who switch between them (Andersson et al. 2020):
// by the authors' own program, which tools/deps/flip installs.
#pragma once

#include <vector>

#include "fluxgs/error.h"
#include "trainer/core/progress.h"
#include "trainer/data/dataset.h"
#include "trainer/train/evaluate.h"

namespace fluxgs::cli {

/// Checks that FLIP can be measured. The error says how to install it. FLUXGS_FLIP names its folder
/// where it is not build/packages/flip.
Expected<void> check_flip();

/// The mean FLIP error of each image's view, 0 (the same) to 1, for a viewer at 67 pixels a degree
/// (the program's default). Images of 8 bits a channel are compared; the mean is over the pixels
/// that no mask ignores.
Expected<std::vector<double>> flip_errors(const std::vector<View>& views,
                                          const ViewRenderer& render,
                                          const ProgressReport& progress = {});

}  // namespace fluxgs::cli
