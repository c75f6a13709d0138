#include "tools/fluxgs/options/tuning_options.h"

#include <map>
#include <numbers>
#include <string_view>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "tools/fluxgs/options/data_options.h"

namespace fluxgs::cli {
namespace {

using render::Accumulation;
using render::SorterKind;
using render::SplatPrecision;
using render::TargetFormat;

}  // namespace

void add_tuning_options(CLI::App& command, TuningOptions& t) {
  const auto shown = [](CLI::Option* option) { option->capture_default_str()->group("Tuning"); };
  shown(command
            .add_option("--sorter", t.sorter,
                        "gpu (radix sort), cpu (on a thread of its own) or exact (float64)")
            ->check(CLI::IsMember({"gpu", "cpu", "exact"})));
  shown(
      command.add_option("--key-bits", t.key_bits, "bits of a depth key")->check(whole_in(10, 32)));
  shown(command.add_option("--digit-bits", t.digit_bits, "bits sorted in each pass of the GPU")
            ->check(whole_in(4, 8)));
  shown(command
            .add_option("--splat-precision", t.splat_precision,
                        "full (32 bytes a splat) or half (16)")
            ->check(CLI::IsMember({"full", "half"})));
  shown(command.add_option("--batch", t.batch, "quads per instance")->check(whole_in(1, 128)));
  shown(command.add_option("--sh-degree", t.sh_degree, "highest SH degree to evaluate")
            ->check(whole_in(0, 3)));
  shown(command.add_option("--format", t.format, "image format")
            ->check(CLI::IsMember({"rgba8", "rgba16f"})));
  shown(command
            .add_option(
                "--blend", t.blend,
                "accumulation buffer format: default (that of view: half on a graphics card), "
                "accurate (best available), float, half or direct")
            ->check(CLI::IsMember({"default", "accurate", "float", "half", "direct"})));
  shown(command.add_option("--scale", t.scale, "render at this fraction of the size, then enlarge")
            ->check(in_range(0.1, 1.0)));
  shown(command.add_option("--alpha-min", t.alpha_min, "alpha cut-off of a splat")
            ->check(in_range(1e-4, 0.5)));
  shown(command
            .add_option("--max-deviations", t.max_deviations,
                        "largest radius of a splat, standard deviations (0: no limit)")
            ->check(in_range(0.0, 100.0)));
  shown(command
            .add_option("--min-weight", t.min_weight,
                        "leave out splats that weigh less: alpha, summed over all pixels")
            ->check(in_range(0.0, 1e6)));
  shown(command
            .add_option(
                "--resort", t.resort_degrees,
                "sort again after the camera has turned by this angle, degrees, or moved likewise")
            ->check(in_range(0.0, 180.0)));
  shown(command
            .add_option("--slices", t.slices,
                        "blend front to back in so many parts, skipping finished pixels (1: off)")
            ->check(whole_in(1, render::kMostSlices)));
  command
      .add_flag("--texture-fetch", t.texture_fetch,
                "read splats from textures, for devices without vertex storage buffers")
      ->group("Tuning");
  command
      .add_flag(
          "--no-compute", t.no_compute,
          "project in fragment shaders and sort on the CPU, for devices without compute shaders")
      ->group("Tuning");
}

render::RendererSettings settings_of(const TuningOptions& t) {
  return {
      .sorter = t.sorter == "gpu"   ? SorterKind::gpu_radix
                : t.sorter == "cpu" ? SorterKind::cpu_async
                                    : SorterKind::exact,
      .splat_precision = t.splat_precision == "half" ? SplatPrecision::half : SplatPrecision::full,
      .batch = t.batch,
      .sort_digit_bits = t.digit_bits,
      .timestamps = true,
      .compute = !t.no_compute,
      .texture_fetch = t.texture_fetch,
      .slices = t.slices,
      .approximation = {.key_bits = t.key_bits,
                        .min_weight = t.min_weight,
                        .max_deviations = t.max_deviations,
                        .resort_motion = t.resort_degrees * std::numbers::pi / 180}};
}

void warn_of_slices(const render::Renderer& renderer, const TuningOptions& t) {
  if (t.slices > 1 && renderer.settings().slices == 1)
    spdlog::warn(
        "warning: --slices {}: this OpenGL cannot read a pixel while it draws (framebuffer fetch), "
        "so splats are blended back to front, as without the option",
        t.slices);
}

RenderOptions tuned(RenderOptions options, const TuningOptions& t) {
  options.sh_degree = t.sh_degree;
  options.alpha_min = t.alpha_min;
  return options;
}

Expected<render::RenderTarget> target_of(gl::Api& api, int width, int height,
                                         const TuningOptions& t) {
  const TargetFormat format = t.format == "rgba16f" ? TargetFormat::rgba16f : TargetFormat::rgba8;
  const std::map<std::string_view, Accumulation> accumulations = {
      {"default", render::default_accumulation(api)},
      {"accurate", render::accurate_accumulation(api.capabilities)},
      {"float", Accumulation::single_float},
      {"half", Accumulation::half_float},
      {"direct", Accumulation::direct}};
  return render::RenderTarget::create(api, width, height, format, accumulations.at(t.blend),
                                      t.scale, t.slices > 1);
}

std::string name_of(const render::RenderTarget& target) {
  return fmt::format("{} blended in {} at {}x{}",
                     render::blend_name(target.format(), Accumulation::direct),
                     render::blend_name(target.format(), target.accumulation()),
                     target.blend_width(), target.blend_height());
}

render::TargetPlan plan_of(const render::RenderTarget& target) {
  return {.width = target.width(),
          .height = target.height(),
          .format = target.format(),
          .accumulation = target.accumulation(),
          .scale = static_cast<double>(target.blend_width()) / target.width(),
          .marks = target.has_marks()};
}

}  // namespace fluxgs::cli
