// A few splats so far from all others that a format's steps of positions would grow with them.
#pragma once

#include <cstddef>

#include "fluxgs/splat_cloud.h"

namespace fluxgs {

/// The median distance of splats from the middle of a finite cloud; 0 without splats.
double median_distance(const SplatCloud& cloud);

/// Moves splats of a finite cloud that lie more than `extent` / 2 (> 0) from its middle along an
/// axis to that distance and makes them as much smaller: seen from the middle they look the same.
/// Only if they are few, one of a thousand or three in all. Returns how many were moved.
std::size_t pull_in_stray_splats(SplatCloud& cloud, double extent);

}  // namespace fluxgs
