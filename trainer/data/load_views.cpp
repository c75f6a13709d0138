#include "trainer/data/load_views.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <new>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <glm/geometric.hpp>

#include <opencv2/imgproc.hpp>

#include "fluxgs/sanitize.h"
#include "trainer/data/image_io.h"
#include "trainer/data/rectify.h"

namespace fluxgs {
namespace {

/// Most images share a lens; its maps are then computed once. A lens of one frame alone is left to
/// that frame's task, so that a data set with a lens per frame does not hold all maps at once.
using SharedLenses = std::map<Lens, std::shared_ptr<const Expected<Rectification>>>;

SharedLenses make_shared_lenses(const std::vector<SourceFrame>& frames) {
  std::map<Lens, const SourceFrame*> first;
  SharedLenses shared;
  for (const SourceFrame& frame : frames)
    if (!first.emplace(frame.lens, &frame).second) shared.emplace(frame.lens, nullptr);
  for (auto& [lens, rectification] : shared)
    rectification = std::make_shared<const Expected<Rectification>>(
        make_rectification(lens, first.at(lens)->file.string()));
  return shared;
}

/// Straight alpha over a background, in stored sRGB values (as NeRF-synthetic does).
void composite(Image<std::uint8_t>& image, const glm::vec3& background) {
  if (image.channels != 4) return;
  int under[3];
  for (int c = 0; c < 3; ++c)
    under[c] = static_cast<int>(std::lround(std::clamp(background[c], 0.0F, 1.0F) * 255.0F));
  const std::size_t count = image.pixels.size() / 4;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* in = &image.pixels[4 * i];
    const int alpha = in[3];
    std::uint8_t rgb[3];
    for (int c = 0; c < 3; ++c)
      rgb[c] = static_cast<std::uint8_t>((in[c] * alpha + under[c] * (255 - alpha) + 127) / 255);
    std::copy_n(rgb, 3, &image.pixels[3 * i]);  // In place: 3i never passes 4i.
  }
  image.pixels.resize(3 * count);
  image.channels = 3;
}

/// Farther away, single precision cannot tell a camera from its neighbours.
constexpr double kFarthest = 1e9;  // scene units

Camera make_camera(const SourceFrame& frame, const Lens& pinhole, int width, int height) {
  const double scale_x = static_cast<double>(width) / pinhole.width;
  const double scale_y = static_cast<double>(height) / pinhole.height;
  return {.name = frame.name,
          .width = width,
          .height = height,
          .fx = pinhole.fx * scale_x,
          .fy = pinhole.fy * scale_y,
          .cx = pinhole.cx * scale_x,
          .cy = pinhole.cy * scale_y,
          .rotation = frame.rotation,
          .translation = frame.translation};
}

Expected<View> make_view(const SourceFrame& frame, const Rectification& rectification,
                         const LoadOptions& options) {
  const std::string file = frame.file.string();
  const glm::dvec3& t = frame.translation;
  if (!(std::max({std::abs(t.x), std::abs(t.y), std::abs(t.z)}) < kFarthest))
    return fail(file, "pose",
                fmt::format("the camera is {:g} units away, expected less than {:g}",
                            glm::length(t), kFarthest));
  auto image = read_image(frame.file);
  if (!image) return std::unexpected(image.error());
  if (frame.orientation > 1) *image = upright(*image, frame.orientation);
  if (image->width != frame.lens.width || image->height != frame.lens.height)
    return fail(file, "",
                fmt::format("the image is {}x{}, expected {}x{} as its camera says", image->width,
                            image->height, frame.lens.width, frame.lens.height));
  const int width = image->width / options.downscale, height = image->height / options.downscale;
  if (width < 1 || height < 1)
    return fail(file, "",
                fmt::format("the image is {}x{}, too small to be reduced {} times", image->width,
                            image->height, options.downscale));

  composite(*image, options.background);
  const cv::Mat stored(image->height, image->width, CV_8UC3, image->pixels.data());
  const cv::Mat undistorted = rectify(stored, rectification);
  View view{.camera = make_camera(frame, rectification.pinhole, width, height),
            .rgb = Image<std::uint8_t>(width, height, 3),
            .path = file};
  cv::Mat target(height, width, CV_8UC3, view.rgb.pixels.data());
  cv::resize(undistorted, target, target.size(), 0, 0, cv::INTER_AREA);
  return view;
}

Expected<View> load_view(const SourceFrame& frame, const SharedLenses& shared,
                         const LoadOptions& options) {
  const std::string file = frame.file.string();
  try {
    const auto found = shared.find(frame.lens);
    const auto rectification =
        found != shared.end()
            ? found->second
            : std::make_shared<const Expected<Rectification>>(make_rectification(frame.lens, file));
    if (!*rectification) return std::unexpected(rectification->error());
    return make_view(frame, **rectification, options);
  } catch (const std::bad_alloc&) {
    return fail(file, "", "not enough memory for the image; reduce the images (downscale)");
  } catch (const cv::Exception& e) {
    return fail(file, "", "the image could not be processed: " + one_line(e.err));
  }
}

}  // namespace

std::vector<Expected<View>> load_views(const std::vector<SourceFrame>& frames,
                                       const LoadOptions& options) {
  std::vector<Expected<View>> loaded(frames.size());
  ProgressCounter counter(options.progress, frames.size());
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] {
    const SharedLenses shared = make_shared_lenses(frames);
    tbb::parallel_for(std::size_t{0}, frames.size(), [&](std::size_t i) {
      loaded[i] = load_view(frames[i], shared, options);
      counter.add_one();
    });
  });
  return loaded;
}

}  // namespace fluxgs
