// The off-screen protocol: how long frames take when no display limits them. The same code on the
// phone and on the desktop.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "bench/samples.h"
#include "bench/traffic_model.h"
#include "render/renderer.h"

namespace fluxgs::bench {

struct FrameBenchmarkOptions {
  int warmup = 20;   ///< frames before any time is taken: clocks rise, caches fill
  int frames = 200;  ///< of each kind
};

struct FrameBenchmark {
  /// From the end of one frame on the GPU to that of the next, with two frames in flight as in an
  /// app; the splats are in order already: cull, project, draw, resolve. Comparable with renderers
  /// that sort elsewhere (Flux-GS, "Deployment on Mobiles").
  Summary in_flight_ms;
  /// Time of such a draw() until the GPU has finished, alone: longer by the way there and back, and
  /// by the clock that a GPU lowers while it waits.
  Summary draw_ms;
  /// The same with the sort of the frame's own view, waited for: what a finger feels.
  Summary sort_to_display_ms;
  /// Time of all frames over their number, sorting as the sorter does
  /// and without waiting between frames.
  double pipelined_ms = 0;
  /// Medians over the frames that were sorted, where the driver has timestamps.
  std::optional<render::FrameTimes> stages;
};

inline constexpr char kStopped[] = "was stopped";

/// Told after each frame how many of all are done; false stops the benchmark.
using FrameProgress = std::function<bool(int done, int all)>;

/// Draws the views in turn, again and again; a moving path is many views a small step apart.
/// Precondition: at least one view, frames ≥ 1. The renderer's approximation are kept. Fails where
/// draw() does, and with Error::what kStopped when it is stopped.
Expected<FrameBenchmark> benchmark_frames(gl::Api& api, render::Renderer& renderer,
                                          const render::RenderTarget& target,
                                          std::span<const Camera> views,
                                          const RenderOptions& options,
                                          const FrameBenchmarkOptions& protocol,
                                          const FrameProgress& progress = {});

/// Counts the last frame of the renderer, of this cloud, camera and target; read back from the GPU.
Expected<FrameCounts> count_frame(const render::Renderer& renderer,
                                  const render::RenderCloud& cloud, const Camera& camera,
                                  const RenderOptions& options, const render::RenderTarget& target);

}  // namespace fluxgs::bench
