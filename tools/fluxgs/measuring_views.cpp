#include "tools/fluxgs/measuring_views.h"

#include "tools/fluxgs/orbit.h"
#include "tools/fluxgs/progress.h"
#include "trainer/compress/contribution.h"

namespace fluxgs::cli {

std::vector<Camera> measuring_views(const SplatCloud& cloud, const Dataset* data) {
  if (data == nullptr) return orbit_around(cloud, kMeasuringViews, {640, 480});
  return spread_cameras(cameras_of(data->train), kMeasuringViews);
}

std::vector<float> contributions_to(const std::vector<Photo>& photos, const SplatCloud& cloud,
                                    const RenderOptions& options, const Threads& threads) {
  return splat_contributions(cloud, cameras_of(photos), options, threads, show_progress("views"));
}

}  // namespace fluxgs::cli
