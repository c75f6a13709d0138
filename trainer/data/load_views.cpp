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
#include "trainer/data/layers.h"
#include "trainer/data/photo_memory.h"
#include "trainer/data/rectify.h"
#include "trainer/data/reduction.h"

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

/// A layer of a photo as the pinhole camera sees it, at the size of the view.
Image<std::uint8_t> reduced(Image<std::uint8_t> layer, const Rectification& rectification,
                            int width, int height) {
  if (layer.pixels.empty()) return {};
  const int type = CV_8UC(layer.channels);
  const cv::Mat stored(layer.height, layer.width, type, layer.pixels.data());
  const cv::Mat undistorted = rectify(stored, rectification);
  Image<std::uint8_t> out(width, height, layer.channels);
  cv::Mat target(height, width, type, out.pixels.data());
  cv::resize(undistorted, target, target.size(), 0, 0, cv::INTER_AREA);
  return out;
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
  auto layers = read_layers(frame, options);
  if (!layers) return std::unexpected(layers.error());
  const auto [width, height] =
      reduced_size({layers->rgb.width, layers->rgb.height}, options.downscale);
  if (width < 1 || height < 1)
    return fail(file, "",
                fmt::format("the image is {}x{}, too small to be reduced {} times",
                            layers->rgb.width, layers->rgb.height, options.downscale));

  const auto at_size = [&](Image<std::uint8_t>& layer) {
    return reduced(std::move(layer), rectification, width, height);
  };
  View view{.camera = make_camera(frame, rectification.pinhole, width, height),
            .rgb = at_size(layers->rgb),
            .path = file,
            .used = at_size(layers->used),
            .alpha = at_size(layers->alpha),
            .background = options.background};
  for (std::uint8_t& v : view.used.pixels) v = v >= kCounts ? 255 : 0;
  return view;
}

Expected<View> load_view(const SourceFrame& frame, const SharedLenses& shared,
                         const LoadOptions& options, PhotoMemory& memory) {
  const std::string file = frame.file.string();
  try {
    const auto found = shared.find(frame.lens);
    const auto rectification =
        found != shared.end()
            ? found->second
            : std::make_shared<const Expected<Rectification>>(make_rectification(frame.lens, file));
    if (!*rectification) return std::unexpected(rectification->error());
    auto view = make_view(frame, **rectification, options);
    if (view) memory.keep(*view);
    return view;
  } catch (const FullDisk& e) {
    memory.tell_full(e.text +
                     "; --downscale makes photos smaller, a larger --photo-memory keeps more of "
                     "them out of files, TMPDIR names another folder");
    return fail(file, "", e.text);
  } catch (const std::bad_alloc&) {
    return fail(file, "", "not enough memory for the image; reduce the images (downscale)");
  } catch (const cv::Exception& e) {
    return fail(file, "", "the image could not be processed: " + one_line(e.err));
  }
}

}  // namespace

std::vector<Expected<View>> load_views(const std::vector<SourceFrame>& frames,
                                       const LoadOptions& options, PhotoMemory& memory) {
  // Errors at first: a view that is assigned to another would leave the memory that it was put into
  std::vector<Expected<View>> loaded(frames.size(), std::unexpected(Error{}));
  ProgressCounter counter(options.progress, frames.size());
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] {
    const SharedLenses shared = make_shared_lenses(frames);
    tbb::parallel_for(std::size_t{0}, frames.size(), [&](std::size_t i) {
      loaded[i] = load_view(frames[i], shared, options, memory);
      counter.add_one();
    });
  });
  return loaded;
}

}  // namespace fluxgs
