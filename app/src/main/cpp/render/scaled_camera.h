// The same view in another number of pixels.
#pragma once

#include "fluxgs/camera.h"

namespace fluxgs::render {

/// Without the name, whose copy would take memory in every frame.
inline Camera scaled_camera(const Camera& camera, int width, int height) {
  const double x = static_cast<double>(width) / camera.width;
  const double y = static_cast<double>(height) / camera.height;
  Camera scaled;
  scaled.width = width;
  scaled.height = height;
  scaled.fx = camera.fx * x;
  scaled.fy = camera.fy * y;
  scaled.cx = camera.cx * x;
  scaled.cy = camera.cy * y;
  scaled.rotation = camera.rotation;
  scaled.translation = camera.translation;
  return scaled;
}

}  // namespace fluxgs::render
