// The renderer's settings that trade speed for error, as options of a sub-command.
#pragma once

#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "fluxgs/render_options.h"
#include "render/memory_estimate.h"
#include "render/render_target.h"
#include "render/renderer.h"
#include "render/settings.h"

namespace fluxgs::cli {

/// The options as they are typed; the defaults are the renderer's.
struct TuningOptions {
  std::string sorter = "gpu", splat_precision = "full", format = "rgba8", blend = "default";
  int key_bits = render::ApproximationSettings().key_bits,
      digit_bits = render::RendererSettings().sort_digit_bits;
  int batch = render::RendererSettings().batch, slices = 1, sh_degree = 3;
  double min_weight = 0, max_deviations = 0, resort_degrees = 0, scale = 1, alpha_min = 1.0 / 255;
  bool texture_fetch = false, no_compute = false;
};

void add_tuning_options(CLI::App& command, TuningOptions& tuning);

render::RendererSettings settings_of(const TuningOptions& tuning);

/// Warns where the renderer's OpenGL draws without the slices that were asked for.
void warn_of_slices(const render::Renderer& renderer, const TuningOptions& tuning);

/// The options with what the tuning says.
RenderOptions tuned(RenderOptions options, const TuningOptions& tuning);

/// Fails where the driver cannot render to that.
Expected<render::RenderTarget> target_of(gl::Api& api, int width, int height,
                                         const TuningOptions& tuning);

/// "RGBA8 blended in RGBA32F at 1280x720".
std::string name_of(const render::RenderTarget& target);

render::TargetPlan plan_of(const render::RenderTarget& target);

}  // namespace fluxgs::cli
