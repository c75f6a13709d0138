#include "trainer/train/antialiasing.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "trainer/data/dataset.h"

namespace fluxgs {
namespace {

constexpr int kInterval = 100;       // iterations, as in Mip-Splatting
constexpr std::size_t kPiece = 256;  // splats of a piece of parallel work
constexpr double kMargin = 0.15;     // of the image's size, as in Mip-Splatting
constexpr double kNearest = 0.01;    // scene units; as RenderOptions::near_plane

/// px per scene unit at a point; 0 where the camera does not show it.
double sampling_rate(const Camera& camera, const glm::dvec3& position) {
  const glm::dvec3 p = camera.rotation * position + camera.translation;
  if (!(p.z > kNearest)) return 0;
  const double x = camera.fx * p.x / p.z + camera.cx, y = camera.fy * p.y / p.z + camera.cy;
  const double mx = kMargin * camera.width, my = kMargin * camera.height;
  const bool shown = x >= -mx && x <= camera.width + mx && y >= -my && y <= camera.height + my;
  return shown ? std::max(camera.fx, camera.fy) / p.z : 0;
}

class Antialiasing final : public Phase {
 public:
  Antialiasing(const AntialiasingOptions& options, int iterations, std::vector<Camera> cameras)
      : options_(options), iterations_(iterations), cameras_(std::move(cameras)) {}

  const char* name() const override { return "anti-aliasing"; }
  Period period() const override {
    return {.from = kInterval, .until = iterations_, .interval = kInterval};
  }
  std::string effect() const override {
    return fmt::format("limits splats to at least {:.2g} px in the nearest view",
                       std::sqrt(options_.min_variance));
  }
  // No state between iterations: a run that is resumed limits the same splats
  std::optional<PhaseReport> after_step(Training& t) override {
    const bool last = t.state.iteration == iterations_;
    if (options_.min_variance > 0 && (last || period().due(t.state.iteration))) limit(t);
    return {};
  }

 private:
  void limit(Training& t) const {
    PlanarFloats& parameters = t.state.parameters;
    const std::vector<float> least =
        min_deviations(parameters, cameras_, options_.min_variance, t.threads);
    for (int axis = 0; axis < 3; ++axis) {
      float* log_scale = parameters.row(row::log_scale + axis);
      for (std::size_t i = 0; i < least.size(); ++i)
        if (least[i] > 0) log_scale[i] = std::max(log_scale[i], std::log(least[i]));
    }
  }

  AntialiasingOptions options_;
  int iterations_;
  std::vector<Camera> cameras_;
};

}  // namespace

OptionFields AntialiasingOptions::fields(const TrainOptions&) {
  return {
      flag("antialias", "anti-aliased scene, for views from nearer and farther than the images",
           antialias),
      real("dilation", "px^2 added to the variances of every splat on the image", dilation, 0.01, 2)
          .only_if(antialias, "--antialias"),
      real("min-variance", "px^2 of the smallest splat in the training view nearest to it",
           min_variance, 0, 10)
          .only_if(antialias, "--antialias")};
}

std::vector<float> min_deviations(const PlanarFloats& parameters, std::span<const Camera> cameras,
                                  double variance, const Threads& threads) {
  std::vector<float> result(parameters.size());
  const auto at = [&](int axis, std::size_t i) {
    return double{parameters.row(row::position + axis)[i]};
  };
  threads.for_pieces(result.size(), kPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const glm::dvec3 position(at(0, i), at(1, i), at(2, i));
      double rate = 0;
      for (const Camera& camera : cameras) rate = std::max(rate, sampling_rate(camera, position));
      if (rate > 0) result[i] = static_cast<float>(std::sqrt(variance) / rate);
    }
  });
  return result;
}

std::unique_ptr<Phase> make_antialiasing(TrainOptions& options, const std::vector<View>& views) {
  const auto& own = options.get<AntialiasingOptions>();
  if (!own.antialias) return nullptr;
  options.render.filter = ScreenFilter{own.dilation, true};
  std::vector<Camera> cameras;
  for (const View& view : views) cameras.push_back(view.camera);
  return std::make_unique<Antialiasing>(own, options.iterations, std::move(cameras));
}

}  // namespace fluxgs
