// How many views the long work of a phase looks at, so that its cost grows with the run and not
// with the number of photos.
#pragma once

#include <algorithm>
#include <cstddef>

namespace fluxgs {

/// Renders of a training view that take about a twentieth of a run. An iteration counts as half of
/// its three renders, since early ones are of few splats on smaller images.
inline double affordable_renders(int iterations) { return 0.05 * 1.5 * iterations; }

/// Views for work that renders each of them so many times in a run (a backward pass counts as
/// two), all in all affordable_renders(), but at least 40 views: 30 of a capture of 40 lose 0.1 dB.
inline std::size_t affordable_views(int iterations, double renders) {
  return static_cast<std::size_t>(std::max(40.0, affordable_renders(iterations) / renders));
}

}  // namespace fluxgs
