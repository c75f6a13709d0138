#include "trainer/model/options.h"

#include <algorithm>

#include <fmt/format.h>

namespace fluxgs {
namespace {

constexpr double kMany = 1e9;

OptionField whole(const char* name, const char* help, int TrainOptions::* field, double low,
                  double high) {
  return {name, help, low, high, field, nullptr, nullptr};
}
OptionField real(const char* name, const char* help, double TrainOptions::* field, double low,
                 double high) {
  return {name, help, low, high, nullptr, field, nullptr};
}
OptionField natural(const char* name, const char* help, std::uint64_t TrainOptions::* field) {
  return {name, help, 0, 1.9e19, nullptr, nullptr, field};
}

double value_of(const TrainOptions& options, const OptionField& f) {
  if (f.integer) return options.*f.integer;
  if (f.real) return options.*f.real;
  return static_cast<double>(options.*f.natural);
}

}  // namespace

const std::vector<OptionField>& option_fields() {
  using O = TrainOptions;
  static const std::vector<OptionField> fields = {
      whole("iterations", "training steps", &O::iterations, 1, kMany),
      natural("seed", "random seed", &O::seed),
      whole("sh-degree", "spherical-harmonics degree", &O::sh_degree, 0, 3),
      whole("sh-degree-interval",
            "steps until the degree in use grows by one (0: an eighth of the steps, at most 1000)",
            &O::sh_degree_interval, 0, kMany),
      real("position-rate", "learning rate of positions, x scene extent", &O::position_rate, 0, 1),
      real("position-rate-final", "the same after --position-decay steps", &O::position_rate_final,
           1e-12, 1),
      whole("position-decay", "steps over which the rate of positions falls", &O::position_decay, 1,
            kMany),
      real("sh-dc-rate", "learning rate of the constant colour", &O::sh_dc_rate, 0, 1),
      real("sh-rest-rate", "learning rate of the other coefficients", &O::sh_rest_rate, 0, 1),
      real("opacity-rate", "learning rate of opacity logits", &O::opacity_rate, 0, 10),
      real("log-scale-rate", "learning rate of log-scales", &O::log_scale_rate, 0, 1),
      real("rotation-rate", "learning rate of quaternions", &O::rotation_rate, 0, 1),
      real("beta1", "Adam: decay of the first moment", &O::beta1, 0, 0.999999),
      real("beta2", "Adam: decay of the second moment", &O::beta2, 0, 0.9999999),
      real("epsilon", "Adam: added to the denominator", &O::epsilon, 1e-30, 1),
      real("lambda-dssim", "weight of 1 - SSIM in the loss", &O::lambda_dssim, 0, 1),
      whole("densify-from", "first step at which splats are added", &O::densify_from, 0, kMany),
      whole("densify-until",
            "last step at which splats are added (0: half of the steps, at most 15000)",
            &O::densify_until, 0, kMany),
      whole("densify-interval", "steps between densifications", &O::densify_interval, 1, kMany),
      real("densify-gradient", "screen-space gradient above which a splat is cloned or split",
           &O::densify_gradient, 0, kMany),
      real("densify-size", "size that separates cloning from splitting, x scene extent",
           &O::densify_size, 0, kMany),
      real("split-shrink", "scales are divided by this when a splat is split", &O::split_shrink, 1,
           100),
      natural("max-splats", "never more splats than this (0: no limit)", &O::max_splats),
      real("prune-opacity", "splats below this opacity are removed", &O::prune_opacity, 0, 1),
      real("prune-screen-radius",
           "px; larger splats are removed after the first opacity reset (0: never)",
           &O::prune_screen_radius, 0, kMany),
      real("prune-world-size",
           "x scene extent; larger splats are removed after the first opacity reset",
           &O::prune_world_size, 0, kMany),
      whole("opacity-reset-interval", "steps between opacity resets (0: never)",
            &O::opacity_reset_interval, 0, kMany),
      real("opacity-reset-to", "opacity after a reset", &O::opacity_reset_to, 1e-4, 0.99),
      real("initial-opacity", "opacity of the first splats", &O::initial_opacity, 1e-3, 0.99),
  };
  return fields;
}

std::vector<std::string> preset_names() { return {"3dgs"}; }

Expected<TrainOptions> preset(std::string_view name) {
  if (name == "3dgs") return TrainOptions{};
  return fail("", "--preset", fmt::format("'{}' is not a preset; expected 3dgs", name));
}

TrainOptions resolved(TrainOptions options) {
  if (options.sh_degree_interval == 0)
    options.sh_degree_interval = std::min(options.iterations / 8 + 1, 1000);
  if (options.densify_until == 0) options.densify_until = std::min(options.iterations / 2, 15000);
  return options;
}

Expected<void> validate(const TrainOptions& options) {
  for (const OptionField& f : option_fields()) {
    const double value = value_of(options, f);
    if (!(value >= f.low && value <= f.high))
      return fail("", fmt::format("--{}", f.name),
                  fmt::format("{:g} is out of range, expected {:g} to {:g}", value, f.low, f.high));
  }
  return {};
}

}  // namespace fluxgs
