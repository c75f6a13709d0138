// Double tap: what is seen in a pixel becomes the centre of attention.
#pragma once

#include <optional>

#include "camera/view_state.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs::camera {

/// Distance along a ray at which the cloud is seen: the median of the distances of the splats near
/// it, weighted by what each adds to the image (its α there times what passes through those before
/// it), so that a wall behind an object does not count. `spread` is the tangent of the ray's
/// half-angle: splats are made larger by that much. Splats nearer than `nearest` are not seen.
/// Nothing where the ray meets next to nothing. Takes a few ns a splat.
std::optional<double> visible_distance(const SplatCloud& cloud, const Ray& ray, double spread,
                                       double nearest);

/// The same for a pixel and a few around it: the point of the scene that is seen there.
std::optional<glm::dvec3> visible_point(const SplatCloud& cloud, const ViewState& view,
                                        const glm::dvec2& pixel, const glm::dvec2& size,
                                        double nearest);

/// The view, moved and not turned, that has a point in its centre, at this part of the present
/// depth of the point (within the limits). Points behind the eye count as at the target's depth.
ViewState focused_on(const ViewState& view, const glm::dvec3& point,
                     const DistanceLimits& limits = {}, double closer = 0.7);

}  // namespace fluxgs::camera
