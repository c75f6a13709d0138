#include "tools/fluxgs/measuring_views.h"

#include "tools/fluxgs/orbit.h"
#include "tools/fluxgs/progress.h"
#include "trainer/compress/view_sensitivity.h"

namespace fluxgs::cli {

std::vector<Camera> measuring_views(const SplatCloud& cloud, const Dataset* data) {
  if (data == nullptr) return orbit_around(cloud, kEvaluationCameras, {640, 480});
  return spread_cameras(cameras_of(data->train), kEvaluationCameras);
}

SensitivityWeights view_sensitivity(const std::vector<View>& views, const SplatCloud& cloud,
                                    const RenderOptions& render, const Threads& threads) {
  return view_sensitivity(cameras_of(views), cloud, false, render, threads, show_progress("views"));
}

}  // namespace fluxgs::cli
