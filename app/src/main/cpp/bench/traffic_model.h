// Estimate of the bytes that a frame moves between the GPU and its memory. On a phone bandwidth
// sets frame rate and heat.
#pragma once

#include <cstdint>
#include <span>

#include "fluxgs/splat_degree.h"
#include "render/memory_estimate.h"
#include "render/scene_constants.h"

namespace fluxgs::bench {

/// Counts of one frame.
struct FrameCounts {
  std::uint64_t splats = 0;     ///< of the scene
  std::uint64_t in_front = 0;   ///< not behind the near plane, nor too low-opacity
  std::uint64_t drawn = 0;      ///< not culled
  double fragments = 0;         ///< that the fragment shader ran for
  int key_bits = 0;             ///< of the frame's depth keys
  DegreeCounts evaluated = {};  ///< the drawn ones by the degree that was evaluated
};

struct FrameTraffic {
  double project = 0, sort = 0, vertices = 0, resolve = 0;  ///< bytes
  /// Blending on a GPU that keeps a tile of the image on the chip (Adreno, Mali): each pixel is
  /// written once.
  double blend_tiled = 0;
  /// Blending on a GPU without: each fragment reads and writes its pixel.
  double blend_immediate = 0;

  double tiled() const { return project + sort + vertices + resolve + blend_tiled; }
  double immediate() const { return project + sort + vertices + resolve + blend_immediate; }
};

/// Caches are taken to catch what is read twice at nearly the same time (the four corners of a quad
/// read one projected splat) and nothing else.
FrameTraffic model_traffic(const FrameCounts& counts, const render::RendererSettings& settings,
                           const render::TargetPlan& target);

/// A splat's quad on the image: corners in order around it, pixels.
struct Quad {
  double x[4], y[4];
};

/// The area of a quad that lies inside of an image, in pixels: how many fragments it makes, up to
/// its border.
double area_inside(const Quad& quad, int width, int height);

}  // namespace fluxgs::bench
