#include "trainer/densify/penalties.h"

#include <cmath>

#include "trainer/core/logistic.h"

namespace fluxgs {
namespace {

constexpr std::size_t kPiece = 1024;  // splats

}  // namespace

bool has_penalties(const TrainOptions& options) {
  return options.opacity_weight > 0 || options.scale_weight > 0;
}

void add_penalties(const PlanarFloats& parameters, const std::vector<std::uint8_t>& visible,
                   const TrainOptions& options, PlanarFloats& gradient, const Threads& threads) {
  const double n = static_cast<double>(parameters.size());
  const auto opacity = static_cast<float>(options.opacity_weight / n);
  const auto scale = static_cast<float>(options.scale_weight / (3 * n));
  threads.for_pieces(parameters.size(), kPiece, [&](std::size_t begin, std::size_t end) {
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

}  // namespace fluxgs
