#include "trainer/densify/penalties.h"

#include <cmath>

#include <fmt/format.h>

#include "fluxgs/math/logistic.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {
namespace {

constexpr std::size_t kPenaltyPiece = 1024;  // splats

class Penalties final : public Phase {
 public:
  Penalties(const PenaltyOptions& options, int iterations)
      : options_(options), iterations_(iterations) {}

  const char* name() const override { return "penalties"; }
  Period period() const override { return {.from = 1, .until = iterations_}; }
  std::string effect() const override {
    return fmt::format("adds {:g} x mean opacity and {:g} x mean size to the loss",
                       options_.opacity_weight, options_.scale_weight);
  }
  void after_backward(Training& t) override {
    add_penalties(t.state.parameters, t.rasterizer.visible(), options_, t.rasterizer.gradient(),
                  t.threads);
  }

 private:
  PenaltyOptions options_;
  int iterations_;
};

}  // namespace

OptionFields PenaltyOptions::fields(const TrainOptions&) {
  return {real("opacity-weight", "weight of the mean opacity in the loss", opacity_weight, 0, 10),
          real("scale-weight", "weight of the mean standard deviation in the loss", scale_weight, 0,
               10)};
}

void add_penalties(const PlanarFloats& parameters, const std::vector<std::uint8_t>& visible,
                   const PenaltyOptions& options, PlanarFloats& gradient, const Threads& threads) {
  const double n = static_cast<double>(parameters.size());
  const auto opacity = static_cast<float>(options.opacity_weight / n);
  const auto scale = static_cast<float>(options.scale_weight / (3 * n));
  threads.for_pieces(parameters.size(), kPenaltyPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (!visible[i]) continue;
      const float o = sigmoid(parameters.row(row::opacity)[i]);
      gradient.row(row::opacity)[i] += opacity * o * (1 - o);
      for (int c = 0; c < 3; ++c)
        gradient.row(row::log_scale + c)[i] +=
            scale * std::exp(parameters.row(row::log_scale + c)[i]);
    }
  });
}

std::unique_ptr<Phase> make_penalties(TrainOptions& options) {
  const auto& own = options.get<PenaltyOptions>();
  if (own.opacity_weight <= 0 && own.scale_weight <= 0) return nullptr;
  return std::make_unique<Penalties>(own, options.iterations);
}

}  // namespace fluxgs
