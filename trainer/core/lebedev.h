// Lebedev's quadrature rules: invariant under the symmetries of the cube.
#pragma once

#include "trainer/core/quadrature.h"

namespace fluxgs {

/// The rule with the fewest directions, at least `samples` of them; 1 ≤ samples ≤
/// kMaxLebedevSamples.
SphereRule lebedev_rule(int samples);

}  // namespace fluxgs
