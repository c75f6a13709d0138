// Cameras and points that structure from motion has put far away from all others.
#pragma once

#include "trainer/data/source.h"

namespace fluxgs {

/// Times the median distance from the median position: a camera that is farther away is stray. The
/// size of the scene, and with it every step of the training, comes from the farthest camera.
inline constexpr double kStrayCamera = 30;
/// The same for points. They may show a sky; positions of a scene are stored in 24 bits an axis.
inline constexpr double kStrayPoint = 1000;

/// Leaves out stray frames, of training and test, and stray points, with a warning each. Fewer than
/// five frames or points are left as they are.
void remove_outliers(Source& source);

}  // namespace fluxgs
