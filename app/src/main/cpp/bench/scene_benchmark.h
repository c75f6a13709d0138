// The benchmark of a scene: sizes, sorters, still views and a path, with what the device is.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/frame_benchmark.h"
#include "fluxgs/io/initial_view.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs::bench {

struct ImageSide {
  int width = 0, height = 0;  ///< px
};

struct SceneBenchmarkPlan {
  std::vector<ImageSide> sizes{{1280, 720}, {1920, 1080}};
  FrameBenchmarkOptions protocol{.warmup = 20, .frames = 100};
  bool gpu_sort = true, cpu_sort = true;
  bool still_views = true, path = true;
  /// Format that the layers are blended in; not given: render::default_accumulation().
  std::optional<render::Accumulation> accumulation = {};
  int slices = 1;  ///< render::RendererSettings::slices
};

/// One way of drawing the scene.
struct SceneBenchmarkRow {
  ImageSide size;
  render::SorterKind sorter = render::SorterKind::gpu_radix;
  bool moves = false;  ///< a path, otherwise still views
  FrameBenchmark times;
  FrameCounts counts;  ///< of the initial view
  FrameTraffic traffic;
  std::string blended_in;  ///< render::blend_name()
  int slices = 1;          ///< that the driver could do
  std::size_t memory = 0;  ///< bytes of the GPU, an estimate
};

struct SceneBenchmark {
  std::vector<SceneBenchmarkRow> rows;
  std::string stopped;  ///< why it ended before all rows were there; empty: it did not
};

/// Eight views around what the scene shows first, and a path of half a degree a frame. Sorted by
/// the size's own aspect.
std::vector<Camera> still_views(const SplatCloud& cloud, const std::optional<InitialView>& start,
                                const ImageSide& size);
std::vector<Camera> path_views(const SplatCloud& cloud, const std::optional<InitialView>& start,
                               const ImageSide& size, int frames);

/// Every size with every sorter on every kind of views, in this order of nesting; none with the
/// GPU's where Quirks::gpu_sort_fails. Sizes that the driver cannot make, and scenes that it has no
/// room for, are errors. A benchmark that is stopped by `progress` has the rows that are
/// finished.
Expected<SceneBenchmark> benchmark_scene(gl::Api& api, const render::RenderCloud& cloud,
                                         const std::optional<InitialView>& start,
                                         const SceneBenchmarkPlan& plan,
                                         const FrameProgress& progress = {});

/// The rows as a JSON list; times in milliseconds. Each row: width, height, sorter ("gpu", "cpu"),
/// views ("still", "path"), in_flight_ms, draw_ms and sort_to_display_ms (median, p95, mean,
/// least), pipelined_ms, stages (project, sort, draw, resolve; null where the driver has no clock),
/// splats_drawn, fragments, blended_in, slices, bytes_per_frame (of a GPU with tiles),
/// gpu_memory_bytes.
std::string rows_json(const SceneBenchmark& benchmark);

/// The driver's description of itself, a JSON object: vendor, renderer, version, quirks,
/// timestamps, float_targets, half_float_targets, max_shared_memory_bytes,
/// max_vertex_storage_blocks, max_texture_size.
std::string driver_json(const gl::Api& api);

}  // namespace fluxgs::bench
