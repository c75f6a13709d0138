// Fewer splats with the least error: those go whose removal changes the images least, a few at a
// time, and the others are fitted to the images of the whole scene in between. No photos are
// needed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/core/adam.h"
#include "trainer/core/parallel.h"
#include "trainer/core/planar_image.h"
#include "trainer/core/profiler.h"
#include "trainer/core/progress.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {

struct ReductionOptions {
  RenderOptions render = {};
  /// Share of the splats that go at once, 0…1. The changes of splats that overlap do not add up:
  /// the smaller, the less is lost, and the longer it takes.
  double share = 0.15;
  int passes = 3;  ///< over all views, of the fit once enough splats are gone; 0: none are fitted
};

/// A scene that loses splats step by step.
class SceneReduction {
 public:
  /// `cameras`: one or more, whose images of `whole` are kept; 12 bytes a pixel. `threads` must
  /// outlive this.
  SceneReduction(const SplatCloud& whole, const std::vector<Camera>& cameras,
                 const ReductionOptions& options, const Threads& threads);

  std::size_t size() const { return parameters_.size(); }
  SplatCloud cloud() const;

  /// Leaves `count` splats, in their order; as many or fewer stay as they are. Splats that no view
  /// sees go first, the least opaque and smallest of them before others. After a stop there may be
  /// more.
  void reduce(std::size_t count, const WorkControl& control = {});

 private:
  struct Target {
    Camera camera;
    PlanarImage color;
  };
  struct Visit {
    bool scores = false;  ///< costs of removal are added to costs_
    double rate = 0;      ///< factor of the learning rates; 0: nothing is fitted
  };
  void visit_all(Visit visit, ProgressCounter& counter, const WorkControl& control);
  void visit_one(const Target& target, const Visit& visit);
  void fit(const PlanarImage& twice_error, double rate);
  void keep(std::size_t count);

  ReductionOptions options_;
  const Threads& threads_;
  ScreenFilter filter_;
  int sh_degree_;
  double extent_;  ///< scene units, about the distance of the cameras from their middle
  std::vector<Target> targets_;
  PlanarFloats parameters_;
  AdamState adam_;
  int steps_ = 0;
  double squared_error_ = 0, values_ = 0;  ///< of the last visits, and how many values they saw
  std::vector<double> costs_;              ///< of removing each splat alone, summed over all views
  std::vector<double> pixels_;             ///< that each splat contributes to
  Profiler profiler_;
  std::unique_ptr<Rasterizer> rasterizer_;
};

}  // namespace fluxgs
