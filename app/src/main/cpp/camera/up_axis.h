// Estimate of the up axis of a scene. Captures come in any frame and no rule is right for all: a
// viewer should let people flip or choose the axis.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "fluxgs/camera.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs::camera {

/// Up in the frame of INRIA's .ply files where nothing better is known: y is down.
inline constexpr glm::dvec3 kDefaultUp{0, -1, 0};

struct UpAxis {
  glm::dvec3 direction = kDefaultUp;  ///< of unit length
  double confidence = 0;              ///< 0: a guess, 1: sure
};

/// Up axis from the cameras of a capture: people hold cameras level, so up is the direction across
/// all of their right axes, on the side of their own ups. The mean of the ups alone is tilted where
/// the cameras look down from one side; it decides only about what the right axes leave open.
/// Dependable unless all images lie on their sides: four captures came out level, 0° to 19° from
/// the mean of the ups. Confidence: the mean cosine of the ups with the result. Without cameras the
/// default up, confidence 0.
UpAxis up_of_cameras(std::span<const Camera> cameras);

/// Up axis from the cloud alone: the thin direction of a scene that is spread out like a disc,
/// because the ground is; splats count by opacity and area. Up is where the thinner tail is (things
/// stand on the ground), unless convention says otherwise more strongly: −y if the axis has
/// something of y, else +z. What is not like a disc (a single object, a wall) gets the default up.
/// A good guess only: of nine scenes with known ups the four discs came out right side up, within
/// 5° (three) and 24° (likeness 0.51); four standing objects got their right up by convention, and
/// a one-sided capture of a wall (0.42) a wrong one. Confidence: how like a disc it is times how
/// clear the side is; below a likeness of 0.45 the default up, confidence 0.
UpAxis up_of_cloud(const SplatCloud& cloud);

}  // namespace fluxgs::camera
