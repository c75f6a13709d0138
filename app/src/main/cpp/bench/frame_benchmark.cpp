#include "bench/frame_benchmark.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>

#include <glm/geometric.hpp>

#include "gl/expected_chain.h"
#include "gl/fence.h"
#include "render/projected_splat.h"
#include "render/sort_view.h"

namespace fluxgs::bench {
namespace {

using render::ApproximationSettings;
using render::ProjectedSplat;
using render::Renderer;
using render::RenderTarget;

// The renderer as it was, whatever happens in between.
class Restored {
 public:
  Restored(Renderer& renderer, const ApproximationSettings& approximation)
      : renderer_(renderer), approximation_(approximation) {}
  Restored(const Restored&) = delete;
  Restored& operator=(const Restored&) = delete;
  ~Restored() {
    renderer_.wait_for_sorts(false);
    static_cast<void>(renderer_.set_approximation(approximation_));
  }

 private:
  Renderer& renderer_;
  ApproximationSettings approximation_;
};

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kLongestFrame{10};

class Protocol {
 public:
  Protocol(gl::Api& api, Renderer& renderer, const ApproximationSettings& approximation,
           const RenderTarget& target, std::span<const Camera> views, const RenderOptions& options,
           const FrameBenchmarkOptions& protocol, const FrameProgress& progress)
      : api_(api),
        renderer_(renderer),
        sorted_(approximation),
        kept_(approximation),
        target_(target),
        views_(views),
        options_(options),
        protocol_(protocol),
        progress_(progress) {
    kept_.resort_motion = std::numeric_limits<double>::max();
  }

  Expected<FrameBenchmark> run() {
    FrameBenchmark result;
    auto done =
        gl::chain([&] { return warm_up(); }, [&] { return time_waiting(result); },
                  [&] { return time_draws(result); }, [&] { return time_in_flight(result); },
                  [&] { return time_pipeline(result); });
    if (!done) return std::unexpected(done.error());
    return result;
  }

 private:
  const Camera& view(int frame) const {
    return views_[static_cast<std::size_t>(frame) % views_.size()];
  }
  Expected<void> draw(int frame) {
    if (sorts_anew_) renderer_.sort_anew();  // also of a view that was drawn just before
    return renderer_.draw(view(frame), options_, target_);
  }

  // Draws with the view's own order.
  Expected<void> draw_sorted(int frame) {
    sorts_anew_ = sorted_.resort_motion == 0;
    return gl::chain([&] { return renderer_.set_approximation(sorted_); },
                     [&] { return draw(frame); });
  }

  Expected<double> timed(int frame) {
    Expected<void> drawn;
    const double ms = milliseconds_of([&] {
      drawn = draw(frame);
      api_.Finish();
    });
    if (!drawn) return std::unexpected(drawn.error());
    ++done_;
    if (auto ok = go_on(); !ok) return std::unexpected(ok.error());
    return ms;
  }

  Expected<void> go_on() const {
    if (!progress_ || progress_(done_, protocol_.warmup + 4 * protocol_.frames)) return {};
    return fail("benchmark", "", kStopped);
  }

  Expected<void> warm_up() {
    renderer_.wait_for_sorts(true);
    if (auto ok = draw_sorted(0); !ok) return ok;
    for (int i = 0; i < protocol_.warmup; ++i)
      if (auto ms = timed(i); !ms) return std::unexpected(ms.error());
    return {};
  }

  Expected<void> time_waiting(FrameBenchmark& result) {
    std::vector<double> samples;
    std::array<std::vector<double>, 4> stages;
    for (int i = 0; i < protocol_.frames; ++i) {
      const auto ms = timed(i);
      if (!ms) return std::unexpected(ms.error());
      samples.push_back(*ms);
      const auto stats = renderer_.stats();
      if (!stats) return std::unexpected(stats.error());
      if (!stats->stages) continue;
      const render::FrameTimes& s = *stats->stages;
      const double times[] = {s.project, s.sort, s.draw, s.resolve};
      for (std::size_t k = 0; k < stages.size(); ++k) stages[k].push_back(times[k]);
    }
    result.sort_to_display_ms = summarize(std::move(samples));
    if (!stages[0].empty()) {
      const auto median = [&](std::size_t k) { return summarize(stages[k]).median; };
      result.stages = render::FrameTimes{median(0), median(1), median(2), median(3)};
    }
    return {};
  }

  // So many frames one after another are of one view, whose order they keep.
  int frames_of_view() const {
    return std::max(1, protocol_.frames / static_cast<int>(views_.size()));
  }

  Expected<void> keep_order_of(int frame) {
    if (auto ok = draw_sorted(frame); !ok) return ok;
    api_.Finish();
    sorts_anew_ = false;
    return renderer_.set_approximation(kept_);
  }

  // Two frames of it, as an app has them: the next is given to the GPU while it draws the last.
  Expected<void> time_in_flight(FrameBenchmark& result) {
    constexpr std::size_t kInFlight = 2;
    std::vector<double> samples;
    std::deque<gl::Fence> ends;
    Clock::time_point last;
    const auto take_end = [&] {
      if (!ends.front().wait(kLongestFrame)) api_.Finish();
      ends.pop_front();
      const Clock::time_point now = Clock::now();
      samples.push_back(std::chrono::duration<double, std::milli>(now - last).count());
      last = now;
    };
    const int per_view = frames_of_view();
    for (int i = 0; i < protocol_.frames; ++i) {
      if (i % per_view == 0) {
        while (!ends.empty()) take_end();
        if (auto ok = keep_order_of(i / per_view); !ok) return ok;
        last = Clock::now();
      }
      if (ends.size() == kInFlight) take_end();
      if (auto ok = draw(i / per_view); !ok) return ok;
      ends.emplace_back(api_);
      ++done_;
      if (auto ok = go_on(); !ok) return ok;
    }
    while (!ends.empty()) take_end();
    result.in_flight_ms = summarize(std::move(samples));
    return {};
  }

  Expected<void> time_draws(FrameBenchmark& result) {
    std::vector<double> samples;
    const int per_view = frames_of_view();
    for (int i = 0; i < protocol_.frames; ++i) {
      const int at = i / per_view;
      if (i % per_view == 0)
        if (auto ok = keep_order_of(at); !ok) return ok;
      const auto ms = timed(at);
      if (!ms) return std::unexpected(ms.error());
      samples.push_back(*ms);
    }
    result.draw_ms = summarize(std::move(samples));
    return {};
  }

  Expected<void> time_pipeline(FrameBenchmark& result) {
    renderer_.wait_for_sorts(false);
    Expected<void> drawn = draw_sorted(0);
    api_.Finish();
    const double ms = milliseconds_of([&] {
      for (int i = 0; i < protocol_.frames && drawn; ++i) {
        drawn = draw(i);
        ++done_;
        if (drawn) drawn = go_on();
      }
      api_.Finish();
    });
    result.pipelined_ms = ms / protocol_.frames;
    return drawn;
  }

  gl::Api& api_;
  Renderer& renderer_;
  ApproximationSettings sorted_, kept_;
  bool sorts_anew_ = false;
  const RenderTarget& target_;
  std::span<const Camera> views_;
  const RenderOptions& options_;
  const FrameBenchmarkOptions& protocol_;
  const FrameProgress& progress_;
  int done_ = 0;
};

// The corners that shaders/splat.vert gives the quad, in order around it.
Quad quad_of(const ProjectedSplat& r, double level_min, double radius_max) {
  constexpr double kPad = 0.0625;
  const double xx = r.factor.x, xy = r.factor.y, yy = r.factor.z;
  const double radius = std::min(std::sqrt(std::max(r.level - level_min, 0.0)), radius_max);
  const double u = radius + kPad * (xx + std::abs(xy)), v = radius + kPad * yy;
  constexpr int kAround[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  Quad quad{};
  for (int i = 0; i < 4; ++i) {
    const double dy = kAround[i][1] * v / yy;
    quad.x[i] = r.centre.x + (kAround[i][0] * u - xy * dy) / xx;
    quad.y[i] = r.centre.y + dy;
  }
  return quad;
}

}  // namespace

Expected<FrameBenchmark> benchmark_frames(gl::Api& api, Renderer& renderer,
                                          const RenderTarget& target, std::span<const Camera> views,
                                          const RenderOptions& options,
                                          const FrameBenchmarkOptions& protocol,
                                          const FrameProgress& progress) {
  const ApproximationSettings approximation = renderer.settings().approximation;
  const Restored restored(renderer, approximation);
  return Protocol(api, renderer, approximation, target, views, options, protocol, progress).run();
}

Expected<FrameCounts> count_frame(const Renderer& renderer, const render::RenderCloud& cloud,
                                  const Camera& camera, const RenderOptions& options,
                                  const RenderTarget& target) {
  const render::RendererSettings& settings = renderer.settings();
  const auto count = static_cast<std::uint32_t>(cloud.size());
  FrameCounts counts;
  counts.splats = count;
  if (count == 0) return counts;
  counts.key_bits = render::sort_view(camera, options.near_plane, renderer.scene(),
                                      settings.approximation.key_bits)
                        .keys.bits;
  const glm::dvec3 centre = camera.center(), forward = camera.forward();
  for (const glm::vec3& p : cloud.base.positions)
    counts.in_front += glm::dot(forward, glm::dvec3(p) - centre) > options.near_plane;

  const int width = target.blend_width(), height = target.blend_height();
  const auto projected_splats = renderer.read_projected(width, height);
  if (!projected_splats) return std::unexpected(projected_splats.error());
  const double level_min = std::log2(options.alpha_min);
  const double deviations = settings.approximation.max_deviations;
  const double radius_max = render::radius_limit(deviations);
  for (std::uint32_t i = 0; i < count; ++i) {
    if (static_cast<double>((*projected_splats)[i].level) < level_min) continue;  // hidden
    ++counts.drawn;
    ++counts
          .evaluated[static_cast<std::size_t>(std::min(options.sh_degree, sh_degree_of(cloud, i)))];
    counts.fragments +=
        area_inside(quad_of((*projected_splats)[i], level_min, radius_max), width, height);
  }
  return counts;
}

}  // namespace fluxgs::bench
