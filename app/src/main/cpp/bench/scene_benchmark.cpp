#include "bench/scene_benchmark.h"

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "camera/initial_view.h"
#include "camera/orbit.h"
#include "gl/expected_chain.h"

namespace fluxgs::bench {
namespace {

using nlohmann::json;

constexpr int kStillViews = 8;
constexpr double kPathStep = 0.5 * std::numbers::pi / 180;  // radians a frame

glm::dvec2 as_vector(const ImageSide& size) { return {size.width, size.height}; }

/// The initial view turned about the scene's up.
Camera turned(const camera::Navigation& first, double angle, const ImageSide& size) {
  // A drag across the shorter side is half a turn
  const double pixels = angle / std::numbers::pi * std::min(size.width, size.height);
  const camera::ViewState view = camera::orbit(first.view, {pixels, 0}, as_vector(size), first.up);
  return camera::camera_of(view, size.width, size.height);
}

/// The GL objects that a row is measured on. Members in the order in which they depend on each
/// other.
struct Stage {
  std::unique_ptr<render::Renderer> renderer;
  render::RenderTarget target;
};

Expected<Stage> set_up(gl::Api& api, const render::RenderCloud& cloud,
                       const SceneBenchmarkPlan& plan, const SceneBenchmarkRow& row) {
  Stage stage;
  const auto accumulation = plan.accumulation.value_or(render::default_accumulation(api));
  const render::RendererSettings settings{
      .sorter = row.sorter,
      .timestamps = true,
      .slices = plan.slices,
      .approximation = render::default_approximation(api.quirks)};
  auto done = gl::chain(
      [&] { return gl::assign_or_error(render::Renderer::create(api, settings), stage.renderer); },
      [&] { return stage.renderer->upload(cloud); },
      [&] {
        return gl::assign_or_error(
            render::RenderTarget::create(api, row.size.width, row.size.height,
                                         render::TargetFormat::rgba8, accumulation, 1,
                                         plan.slices > 1),
            stage.target);
      });
  if (!done) return std::unexpected(done.error());
  return stage;
}

render::TargetPlan plan_of(const render::RenderTarget& target) {
  return {.width = target.width(),
          .height = target.height(),
          .format = target.format(),
          .accumulation = target.accumulation(),
          .marks = target.has_marks()};
}

std::vector<SceneBenchmarkRow> rows_of(const SceneBenchmarkPlan& plan, const gl::Quirks& quirks) {
  using render::SorterKind;
  const bool gpu_sort = plan.gpu_sort && !quirks.gpu_sort_fails;
  std::vector<SceneBenchmarkRow> rows;
  for (const ImageSide& size : plan.sizes)
    for (const auto& [sorter, wanted] : {std::pair(SorterKind::gpu_radix, gpu_sort),
                                         std::pair(SorterKind::cpu_async, plan.cpu_sort)})
      for (const auto& [moves, asked] :
           {std::pair(false, plan.still_views), std::pair(true, plan.path)}) {
        if (!wanted || !asked) continue;
        SceneBenchmarkRow& row = rows.emplace_back();
        row.size = size;
        row.sorter = sorter;
        row.moves = moves;
      }
  return rows;
}

Expected<void> measure(gl::Api& api, const render::RenderCloud& cloud,
                       const std::optional<InitialView>& start, const SceneBenchmarkPlan& plan,
                       const FrameProgress& progress, SceneBenchmarkRow& row) {
  auto stage = set_up(api, cloud, plan, row);
  if (!stage) return std::unexpected(stage.error());
  const std::vector<Camera> views =
      row.moves ? path_views(cloud.base, start, row.size, plan.protocol.frames)
                : still_views(cloud.base, start, row.size);
  const RenderOptions options{
      .near_plane =
          camera::initial_navigation(cloud.base, start, as_vector(row.size)).units.near_plane};
  const auto times = benchmark_frames(api, *stage->renderer, stage->target, views, options,
                                      plan.protocol, progress);
  if (!times) return std::unexpected(times.error());
  row.times = *times;
  if (auto drawn = stage->renderer->draw(views.front(), options, stage->target); !drawn)
    return drawn;
  const auto counts = count_frame(*stage->renderer, cloud, views.front(), options, stage->target);
  if (!counts) return std::unexpected(counts.error());
  row.counts = *counts;
  const render::RendererSettings& settings = stage->renderer->settings();
  row.blended_in = render::blend_name(stage->target.format(), stage->target.accumulation());
  row.slices = settings.slices;
  row.traffic = model_traffic(row.counts, settings, plan_of(stage->target));
  row.memory =
      render::estimate_memory(count_degrees(cloud), settings, plan_of(stage->target)).total();
  return {};
}

json json_of(const Summary& s) {
  return {{"median", s.median}, {"p95", s.p95}, {"mean", s.mean}, {"least", s.least}};
}

json json_of(const std::optional<render::FrameTimes>& stages) {
  if (!stages) return nullptr;
  return {{"project", stages->project},
          {"sort", stages->sort},
          {"draw", stages->draw},
          {"resolve", stages->resolve}};
}

json json_of(const SceneBenchmarkRow& row) {
  return {{"width", row.size.width},
          {"height", row.size.height},
          {"sorter", row.sorter == render::SorterKind::gpu_radix ? "gpu" : "cpu"},
          {"views", row.moves ? "path" : "still"},
          {"in_flight_ms", json_of(row.times.in_flight_ms)},
          {"draw_ms", json_of(row.times.draw_ms)},
          {"sort_to_display_ms", json_of(row.times.sort_to_display_ms)},
          {"pipelined_ms", row.times.pipelined_ms},
          {"stages", json_of(row.times.stages)},
          {"splats_drawn", row.counts.drawn},
          {"fragments", row.counts.fragments},
          {"blended_in", row.blended_in},
          {"slices", row.slices},
          {"bytes_per_frame", row.traffic.tiled()},
          {"gpu_memory_bytes", row.memory}};
}

}  // namespace

std::vector<Camera> still_views(const SplatCloud& cloud, const std::optional<InitialView>& start,
                                const ImageSide& size) {
  const camera::Navigation first = camera::initial_navigation(cloud, start, as_vector(size));
  std::vector<Camera> views;
  for (int i = 0; i < kStillViews; ++i)
    views.push_back(turned(first, 2 * std::numbers::pi * i / kStillViews, size));
  return views;
}

std::vector<Camera> path_views(const SplatCloud& cloud, const std::optional<InitialView>& start,
                               const ImageSide& size, int frames) {
  const camera::Navigation first = camera::initial_navigation(cloud, start, as_vector(size));
  std::vector<Camera> views;
  for (int i = 0; i < frames; ++i) views.push_back(turned(first, i * kPathStep, size));
  return views;
}

Expected<SceneBenchmark> benchmark_scene(gl::Api& api, const render::RenderCloud& cloud,
                                         const std::optional<InitialView>& start,
                                         const SceneBenchmarkPlan& plan,
                                         const FrameProgress& progress) {
  SceneBenchmark result;
  std::vector<SceneBenchmarkRow> rows = rows_of(plan, api.quirks);
  if (rows.empty())
    return fail("benchmark", "sorter",
                "this driver cannot sort on the GPU, and no other is asked for");
  const int count = static_cast<int>(rows.size());
  for (int i = 0; i < count; ++i) {
    SceneBenchmarkRow& row = rows[static_cast<std::size_t>(i)];
    const FrameProgress whole = [&](int done, int all) {
      return !progress || progress(i * all + done, count * all);
    };
    if (auto ok = measure(api, cloud, start, plan, whole, row); !ok) {
      if (ok.error().what != kStopped) return std::unexpected(ok.error());
      result.stopped = kStopped;
      break;
    }
    result.rows.push_back(row);
  }
  return result;
}

std::string rows_json(const SceneBenchmark& benchmark) {
  json list = json::array();
  for (const SceneBenchmarkRow& row : benchmark.rows) list.push_back(json_of(row));
  return list.dump();
}

std::string driver_json(const gl::Api& api) {
  const gl::Capabilities& c = api.capabilities;
  return json{{"vendor", c.vendor},
              {"renderer", c.renderer},
              {"version", c.version},
              {"extensions", c.extensions},
              {"quirks", api.quirks.names()},
              {"timestamps", c.timestamps},
              {"half_float_targets", c.half_float_targets},
              {"float_targets", c.float_targets},
              {"max_shared_memory_bytes", c.max_shared_memory_bytes},
              {"compute", c.compute},
              {"max_vertex_storage_blocks", c.max_vertex_storage_blocks},
              {"max_texture_size", c.max_texture_size}}
      .dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace fluxgs::bench
