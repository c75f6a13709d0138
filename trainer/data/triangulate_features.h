// Sparse points from images with known poses.
#pragma once

#include <vector>

#include "trainer/data/initial_points.h"

namespace fluxgs {

/// Match SIFT features between each image and the few that see the same thing from a useful angle,
/// join the matches to tracks, and intersect each track's rays. A point is kept if it is in front
/// of all its cameras, reprojects within feature_tolerance() (2 px) of every feature of the track,
/// and is seen under at least 1° of parallax. Its colour is the mean of the images' pixels.
/// Deterministic, whatever the number of threads; may find nothing. Progress counts pairs matched.
PointCloud triangulate_features(const std::vector<View>& views, const Threads& threads,
                                const ProgressReport& progress = {});

/// The pairs of images (i < j, sorted) worth matching: for each image the few whose directions to
/// its focus differ by a useful parallax (best about 10°) and that look the same way.
std::vector<std::pair<int, int>> choose_pairs(const std::vector<View>& views);

}  // namespace fluxgs
