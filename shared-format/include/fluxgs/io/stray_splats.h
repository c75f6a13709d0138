// Splats so far from all others, of so strong a colour, or so large or small that the steps of a
// format would grow with them.
#pragma once

#include <cstddef>

#include "fluxgs/splat_cloud.h"

namespace fluxgs {

/// The median distance of splats from the middle of a finite cloud; 0 without splats.
double median_distance(const SplatCloud& cloud);

/// Moves splats of a finite cloud that lie more than `extent` / 2 (> 0) from its middle along an
/// axis to that distance and makes them as much smaller, down to the limit of limit_stray_sizes():
/// seen from the middle they look the same. Only if they are few, one of a thousand or three in
/// all. Returns how many were moved.
std::size_t pull_in_stray_splats(SplatCloud& cloud, double extent);

/// Limits standard deviations along an axis of a finite cloud to e⁻¹² … e¹⁶ times the usual one of
/// the scene (the median, itself taken to be e⁻³⁰ … e³⁰; of fewer than twelve splats the range is
/// narrower): smaller ones are no wider than the blur of any image, larger ones are flat all over
/// it. Returns how many splats were larger: they alone may look different, from far outside.
std::size_t limit_stray_sizes(SplatCloud& cloud);

/// Limits coefficients of colours that are more than ten times as large as nearly all others are
/// (and as black and white): of one splat of a thousand or three in all, at most. They are brighter
/// than any display before and after. Returns the number of splats.
std::size_t limit_stray_colors(SplatCloud& cloud);

}  // namespace fluxgs
