// Choice of the views that scores are taken from (paper, "Stratified Camera Sampling").
#pragma once

#include <cstdint>
#include <vector>

#include "trainer/core/random.h"
#include "trainer/data/dataset.h"
#include "trainer/densify/splat_scores.h"

namespace fluxgs {

/// Groups of images (by index) whose cameras lie in the same bin of azimuth and elevation around
/// the point that they look at (paper, "Stratified Camera Sampling"): the point nearest to all view
/// directions, or where these are parallel the mean of the points at their focus distances. The
/// axis is the data set's own z (as in the paper), upright or not. Empty bins are left out.
std::vector<std::vector<std::uint32_t>> camera_bins(const std::vector<View>& views, int azimuth,
                                                    int elevation);

/// Draws `views` different images, or all of them if there are fewer. Stratified: one from
/// each bin, the bins in random order; then a second one from each, where that does not suffice.
std::vector<std::uint32_t> sample_cameras(const std::vector<View>& views,
                                          const ScoreOptions& options, Random& random);

}  // namespace fluxgs
