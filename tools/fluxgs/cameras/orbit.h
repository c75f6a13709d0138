// Cameras around a scene.
#pragma once

#include <optional>
#include <vector>

#include "camera/navigation.h"
#include "fluxgs/camera.h"
#include "fluxgs/io/initial_view.h"
#include "fluxgs/splat_cloud.h"
#include "tools/fluxgs/cameras/cameras.h"
#include "trainer/data/dataset.h"

namespace fluxgs::cli {

/// `count` cameras on a circle that follows the images': their centre of attention, mean height,
/// distance, field of view and up direction. Images from all around give a full circle; if they
/// leave out more than a quarter of it, the cameras go from near one end of the covered arc to near
/// the other (one camera stands in its middle). `views` has at least one.
std::vector<Camera> orbit_along(const std::vector<View>& views, int count, const ImageSize& size);

/// `count` cameras on a circle around the middle of the splats, slightly above; y is down, as in
/// most scenes.
std::vector<Camera> orbit_around(const SplatCloud& cloud, int count, const ImageSize& size);

/// `count` cameras on a circle about a scene's up axis: through the eye of the view, around what it
/// looks at, with its field of view.
std::vector<Camera> orbit_through(const camera::Navigation& start, int count,
                                  const ImageSize& size);

/// Cameras over which a compact scene is compared with the uncompressed one: at most
/// kEvaluationCameras, evenly spread over the training views; without `data`, on an orbit around
/// the scene, 640x480.
std::vector<Camera> evaluation_cameras(const SplatCloud& cloud, const Dataset* data);

/// Size of images that tell which of so many splats can go, 160x120 to 640x480: few splats are
/// large ones, for which few pixels are enough.
ImageSize reduction_size(std::size_t splats);

/// Cameras whose images a scene keeps when it loses splats: at most 48, of reduction_size(), evenly
/// spread over the training views; without `data` on circles around the scene at three heights and,
/// where the scene has a start view, through that.
std::vector<Camera> reduction_cameras(const SplatCloud& cloud,
                                      const std::optional<InitialView>& start, const Dataset* data);

}  // namespace fluxgs::cli
