#include "trainer/densify/opacity_reset.h"

#include <algorithm>

#include <fmt/format.h>

#include "fluxgs/math/logistic.h"
#include "trainer/densify/densification.h"

namespace fluxgs {
namespace {

class OpacityReset final : public Phase {
 public:
  OpacityReset(const OpacityResetOptions& options, int until) : options_(options), until_(until) {}

  const char* name() const override { return "opacity reset"; }
  Period period() const override {
    return {.from = 1, .until = until_, .interval = options_.interval};
  }
  std::string effect() const override {
    return fmt::format("limits opacities to {:g}", options_.to);
  }
  std::optional<PhaseReport> after_step(Training& t) override {
    if (period().due(t.state.iteration)) reset_opacity(t.state, options_.to);
    return {};
  }

 private:
  OpacityResetOptions options_;
  int until_;
};

}  // namespace

OptionFields OpacityResetOptions::fields(const TrainOptions& all) {
  const bool by_gradients = all.get<DensificationOptions>().strategy != Densify::mcmc;
  return {whole("opacity-reset-interval",
                "iterations between opacity resets, until the last densification (0: never)",
                interval, 0, kUnlimited)
              .only_if(by_gradients, "--densify gradient or multiview"),
          real("opacity-reset-to", "maximum opacity after a reset", to, 1e-4, 0.99)
              .only_if(resets_opacity(all),
                       "--densify gradient or multiview with an --opacity-reset-interval below "
                       "--densify-until")};
}

bool resets_opacity(const TrainOptions& options) {
  const auto& densification = options.get<DensificationOptions>();
  const auto& own = options.get<OpacityResetOptions>();
  // None with the last densification: nothing would remove splats whose opacity stays low
  return densification.strategy != Densify::mcmc && own.interval > 0 &&
         own.interval < densification.until;
}

void reset_opacity(TrainState& state, double to) {
  const auto limit = static_cast<float>(logit(to));
  float* opacity = state.parameters.row(row::opacity);
  for (std::size_t i = 0; i < state.parameters.size(); ++i) {
    opacity[i] = std::min(opacity[i], limit);
    state.adam.first.row(row::opacity)[i] = 0;
    state.adam.second.row(row::opacity)[i] = 0;
  }
}

std::unique_ptr<Phase> make_opacity_reset(TrainOptions& options) {
  if (!resets_opacity(options)) return nullptr;
  const auto& own = options.get<OpacityResetOptions>();
  return std::make_unique<OpacityReset>(own, options.get<DensificationOptions>().until - 1);
}

}  // namespace fluxgs
