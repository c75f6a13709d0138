#include "bench/driver_check.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "gl/expected_chain.h"
#include "render/renderer.h"
#include "render/sort_view.h"
#include "sort/cpu_radix_sort.h"

namespace fluxgs::bench {
namespace {

constexpr std::uint32_t kAll = std::numeric_limits<std::uint32_t>::max();

using render::Accumulation;
using render::DriverLimits;

/// The part of a drawing that went wrong, as far as that is known.
enum class Suspect {
  none,
  sort,
  vertex_storage,
  float_targets,
  compute,
  fragment_projection,
  unknown
};

struct Attempt {
  Suspect suspect = Suspect::none;
  std::string fault = {};  ///< one line; empty where the picture is right
  double psnr = 0;
};

Accumulation accumulation_for(const DriverLimits& limits, const gl::Api& api) {
  return limits.no_float_targets ? Accumulation::direct : render::default_accumulation(api);
}

render::RendererSettings settings_for(const DriverLimits& limits, const gl::Quirks& quirks) {
  return {
      .sorter = limits.no_gpu_sort ? render::SorterKind::cpu_async : render::SorterKind::gpu_radix,
      .compute = !limits.no_compute,
      .project_in_vertices = limits.no_fragment_projection,
      .texture_fetch = limits.no_vertex_storage,
      .approximation = render::default_approximation(quirks)};
}

/// By the shader that its message names.
Suspect suspect_of(const Error& error) {
  const std::string text = error.message();
  if (text.contains("sort_")) return Suspect::sort;
  if (text.contains("splat.")) return Suspect::vertex_storage;
  if (text.contains(".comp")) return Suspect::compute;
  if (text.contains("project.frag")) return Suspect::fragment_projection;
  return Suspect::unknown;
}

double psnr_of(const Image<float>& image, const Image<std::uint8_t>& golden) {
  double sum = 0;
  for (int y = 0; y < golden.height; ++y)
    for (int x = 0; x < golden.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double error = static_cast<double>(image.at(x, y)[c]) - golden.at(x, y)[c] / 255.0;
        sum += std::isfinite(error) ? error * error : 1;
      }
  constexpr double kLeastMse = 1e-10;
  return -10 * std::log10(std::max(sum / (3.0 * golden.width * golden.height), kLeastMse));
}

/// Compares the order of the last frame with that of its keys. A line if they differ.
Expected<std::string> fault_of_order(const render::Renderer& renderer) {
  const auto keys = renderer.projection().keys().read_all<std::uint32_t>(renderer.scene().count);
  if (!keys) return std::unexpected(keys.error());
  sort::RadixScratch scratch(keys->size());
  std::vector<std::uint32_t> expected(keys->size());
  expected.resize(sort::radix_sort(*keys, sort::kMaxKeyBits, scratch, expected));
  const auto count = renderer.sorter().count().read_all<std::uint32_t>(1);
  if (!count) return std::unexpected(count.error());
  if (count->front() != expected.size())
    return fmt::format("the sort kept {} splats of {}", count->front(), expected.size());
  const auto order = renderer.sorter().order().read_all<std::uint32_t>(expected.size());
  if (!order) return std::unexpected(order.error());
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) wrong += (*order)[i] != expected[i];
  return wrong == 0
             ? std::string()
             : fmt::format("the sort put {} splats of {} in a wrong place", wrong, expected.size());
}

/// The depth keys of the last frame; nothing where nobody makes them.
Expected<std::vector<std::uint32_t>> keys_of(const render::Renderer& renderer) {
  if (!renderer.settings().compute) return std::vector<std::uint32_t>();
  return renderer.projection().keys().read_all<std::uint32_t>(renderer.scene().count);
}

}  // namespace

std::string ProjectionCheck::fault() const {
  if (seen == 0) return "the projection kept no splat";
  return misplaces()
             ? fmt::format("the projection put {} splats of {} in a wrong place", wrong, seen)
             : std::string();
}

Expected<ProjectionCheck> check_projection(const render::Renderer& renderer,
                                           const SplatCloud& scene, const Camera& camera,
                                           double near_plane, std::uint32_t most) {
  const auto count = static_cast<std::uint32_t>(std::min<std::size_t>(scene.size(), most));
  const auto keys = keys_of(renderer);
  if (!keys) return std::unexpected(keys.error());
  const render::RendererSettings& settings = renderer.settings();
  const auto splats = renderer.read_projected(camera.width, camera.height, count);
  if (!splats) return std::unexpected(splats.error());
  const sort::DepthKeys depths =
      render::sort_view(camera, near_plane, renderer.scene(), settings.approximation.key_bits).keys;
  constexpr double kNearby = 0.1;        // px
  constexpr float kLeastLevel = -1e29F;  // below: hidden, its centre was not written
  ProjectionCheck check;
  for (std::uint32_t i = 0; i < count; ++i) {
    const render::ProjectedSplat& splat = (*splats)[i];
    if (!(splat.level > kLeastLevel)) continue;
    const glm::dvec3 p = camera.rotation * glm::dvec3(scene.positions[i]) + camera.translation;
    const glm::dvec2 centre(camera.fx * p.x / p.z + camera.cx, camera.fy * p.y / p.z + camera.cy);
    bool right = glm::distance(centre, glm::dvec2(splat.centre)) < kNearby;
    if (!keys->empty()) {
      const std::int64_t key = sort::depth_key(depths, static_cast<float>(p.z));
      // Depths are rounded a few times on their way, here they are not
      const std::int64_t rounding = 1 + (64 >> depths.shift);
      right = right && std::abs(key - std::int64_t{(*keys)[i]}) <= rounding;
    }
    ++check.seen;
    check.wrong += right ? 0 : 1;
  }
  return check;
}

namespace {

/// Draws in one way and looks at what came out.
class OneWay {
 public:
  OneWay(gl::Api& api, const DriverLimits& limits) : api_(api), limits_(limits) {}

  Attempt run(const SplatCloud& scene, const Camera& camera, double near_plane,
              const Image<std::uint8_t>& golden) {
    gl::clear_errors(api_);
    if (auto made = make(scene); !made) return {suspect_of(made.error()), made.error().message()};
    auto target =
        render::RenderTarget::create(api_, camera.width, camera.height, render::TargetFormat::rgba8,
                                     accumulation_for(limits_, api_));
    if (!target) return {Suspect::float_targets, target.error().message()};
    renderer_->wait_for_sorts(true);
    auto drawn =
        gl::chain([&] { return renderer_->draw(camera, {.near_plane = near_plane}, *target); },
                  [&] { return gl::check_errors(api_, "drawing"); });
    if (!drawn) return {Suspect::unknown, drawn.error().message()};
    const auto projected = check_projection(*renderer_, scene, camera, near_plane, kAll);
    if (!projected) return {Suspect::unknown, projected.error().message()};
    if (std::string fault = projected->fault(); !fault.empty())
      return {renderer_->settings().compute ? Suspect::compute : Suspect::fragment_projection,
              std::move(fault)};
    return judge(*target, golden);
  }

 private:
  Expected<void> make(const SplatCloud& scene) {
    return gl::chain(
        [&] {
          return gl::assign_or_error(
              render::Renderer::create(api_, settings_for(limits_, api_.quirks)), renderer_);
        },
        [&] { return renderer_->upload(scene); },
        [&] { return gl::check_errors(api_, "loading the scene"); });
  }

  Attempt judge(const render::RenderTarget& target, const Image<std::uint8_t>& golden) {
    const auto image = renderer_->read(target);
    if (!image) return {Suspect::unknown, image.error().message()};
    const double psnr = psnr_of(*image, golden);
    if (renderer_->settings().sorter == render::SorterKind::gpu_radix) {
      const auto fault = fault_of_order(*renderer_);
      if (!fault) return {Suspect::unknown, fault.error().message(), psnr};
      if (!fault->empty()) return {Suspect::sort, *fault, psnr};
    }
    const double least = limits_.no_float_targets ? kLeastPsnrInBytes : kLeastPsnr;
    if (psnr >= least) return {.psnr = psnr};
    return {Suspect::unknown,
            fmt::format("the picture is {:.1f} dB from the golden one; expected at least {:g}",
                        psnr, least),
            psnr};
  }

  gl::Api& api_;
  DriverLimits limits_;
  std::unique_ptr<render::Renderer> renderer_;
};

/// The limit that takes a known fault away; none where it is set already.
DriverLimits remedy(Suspect suspect, const DriverLimits& limits) {
  return {.no_gpu_sort = suspect == Suspect::sort && !limits.no_gpu_sort,
          .no_vertex_storage = suspect == Suspect::vertex_storage && !limits.no_vertex_storage,
          .no_float_targets = suspect == Suspect::float_targets && !limits.no_float_targets,
          .no_compute = suspect == Suspect::compute && !limits.no_compute,
          .no_fragment_projection =
              suspect == Suspect::fragment_projection && !limits.no_fragment_projection};
}

DriverLimits both(const DriverLimits& a, const DriverLimits& b) {
  return {.no_gpu_sort = a.no_gpu_sort || b.no_gpu_sort,
          .no_vertex_storage = a.no_vertex_storage || b.no_vertex_storage,
          .no_float_targets = a.no_float_targets || b.no_float_targets,
          .no_compute = a.no_compute || b.no_compute,
          .no_fragment_projection = a.no_fragment_projection || b.no_fragment_projection};
}

std::string way(const DriverLimits& limits) {
  const auto names = limits.names();
  return names.empty() ? "as fast as it can" : fmt::format("with {}", fmt::join(names, ", "));
}

}  // namespace

namespace {

/// The first few mistakes from that one on, each cut to one line of a log.
std::vector<std::string> first_messages(const gl::DebugLog& log, std::size_t from) {
  constexpr std::size_t kMost = 8, kLongest = 300;
  std::vector<std::string> texts;
  const auto mistakes = log.mistakes();
  for (std::size_t i = std::min(from, mistakes.size()); i < mistakes.size(); ++i)
    if (texts.size() < kMost) texts.push_back(mistakes[i].text.substr(0, kLongest));
  return texts;
}

}  // namespace

DriverCheck check_driver(gl::Api& api, const SplatCloud& scene, const Camera& camera,
                         double near_plane, const Image<std::uint8_t>& golden) {
  DriverCheck check;
  const std::size_t said_before = api.debug.mistakes().size();
  DriverLimits known;  // that faults have asked for by name
  const auto attempt = [&](const DriverLimits& limits) {
    const Attempt done = OneWay(api, limits).run(scene, camera, near_plane, golden);
    check.psnr = done.psnr;
    check.right = done.suspect == Suspect::none;
    check.limits = limits;
    if (!check.right) check.faults.push_back(way(limits) + ": " + done.fault);
    return remedy(done.suspect, limits);
  };
  // The ways that are left where a fault has no name, the cheapest first
  constexpr DriverLimits kLadder[] = {{},
                                      {.no_vertex_storage = true},
                                      {.no_float_targets = true},
                                      {.no_vertex_storage = true, .no_float_targets = true},
                                      {true, true, true},
                                      {.no_compute = true},
                                      {.no_float_targets = true, .no_compute = true}};
  for (const DriverLimits& rung : kLadder) {
    if (!check.faults.empty() && both(known, rung) == check.limits) continue;  // just tried
    for (DriverLimits needed = attempt(both(known, rung)); needed != DriverLimits();) {
      known = both(known, needed);
      needed = attempt(both(known, rung));
    }
    if (check.right || gl::context_lost(api)) break;
  }
  check.messages = first_messages(api.debug, said_before);
  return check;
}

std::string to_json(const DriverCheck& check, const gl::Api& api) {
  using nlohmann::json;
  return json{{"renderer", api.capabilities.renderer},
              {"version", api.capabilities.version},
              {"right", check.right},
              {"limits", check.limits.names()},
              {"psnr", check.psnr},
              {"faults", check.faults},
              {"messages", check.messages}}
      .dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace fluxgs::bench
