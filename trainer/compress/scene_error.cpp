#include "trainer/compress/scene_error.h"

#include <algorithm>
#include <utility>

#include "trainer/raster/view_renderer.h"

namespace fluxgs {
namespace {

double squares(const PlanarImage& a, const PlanarImage& b) {
  double sum = 0;
  for (int c = 0; c < a.channels(); ++c)
    for (int y = 0; y < a.height(); ++y)
      for (int x = 0; x < a.width(); ++x) {
        const double d = double{std::clamp(a.row(c, y)[x], 0.0f, 1.0f)} -
                         double{std::clamp(b.row(c, y)[x], 0.0f, 1.0f)};
        sum += d * d;
      }
  return sum;
}

}  // namespace

SceneError::SceneError(const SplatCloud& uncompressed, std::vector<Camera> cameras,
                       const RenderOptions& options, const Threads& threads,
                       std::function<bool()> stop)
    : cameras_(std::move(cameras)), options_(options), threads_(threads), stop_(std::move(stop)) {
  const ViewRenderer render = cpu_view_renderer(uncompressed, options_, threads_);
  // The trainer's own renderer has no way to fail
  for (const Camera& camera : cameras_) expected_.push_back(*render(camera));
}

Expected<double> SceneError::mse(const SplatCloud& other) const {
  const ViewRenderer render = cpu_view_renderer(other, options_, threads_);
  double sum = 0, values = 0;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    if (stop_ && stop_()) return fail("", "", "stopped");
    const auto image = render(cameras_[i]);
    if (!image) return std::unexpected(image.error());
    sum += squares(*image, expected_[i]);
    values += 3.0 * image->width() * image->height();
  }
  return values > 0 ? sum / values : 0;
}

}  // namespace fluxgs
