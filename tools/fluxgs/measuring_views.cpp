#include "tools/fluxgs/measuring_views.h"

#include <algorithm>

#include "tools/fluxgs/orbit.h"
#include "tools/fluxgs/progress.h"
#include "trainer/compress/contribution.h"

namespace fluxgs::cli {

std::vector<Camera> measuring_views(const SplatCloud& cloud, const Dataset* data) {
  if (data == nullptr) return orbit_around(cloud, kMeasuringViews, {640, 480});
  std::vector<Camera> cameras;
  const std::size_t photos = data->train.size();
  const auto count = std::min(photos, static_cast<std::size_t>(kMeasuringViews));
  for (std::size_t i = 0; i < count; ++i)
    cameras.push_back(data->train[(2 * i + 1) * photos / (2 * count)].camera);
  return cameras;
}

std::vector<float> contributions_to(const std::vector<Photo>& photos, const SplatCloud& cloud,
                                    const RenderOptions& options, const Threads& threads) {
  std::vector<Camera> cameras;
  for (const Photo& photo : photos) cameras.push_back(photo.camera);
  return splat_contributions(cloud, cameras, options, threads, show_progress("views"));
}

}  // namespace fluxgs::cli
