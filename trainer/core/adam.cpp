#include "trainer/core/adam.h"

#include <cmath>

namespace fluxgs {
namespace {

constexpr std::size_t kAdamPiece = 2048;  // splats

double rate_of(const LearningRates& rates, int r) {
  if (r < row::log_scale) return rates.position;
  if (r < row::rotation) return rates.log_scale;
  if (r < row::opacity) return rates.rotation;
  if (r < row::sh_dc) return rates.opacity;
  return r < row::sh_rest ? rates.sh_dc : rates.sh_rest;
}

}  // namespace

AdamStep::AdamStep(const AdamConstants& constants, int step, const AdamKernels& kernels)
    : constants_(constants),
      correction1_(1 / (1 - std::pow(constants.beta1, step))),
      correction2_(1 / (1 - std::pow(constants.beta2, step))),
      kernels_(kernels) {}

void AdamStep::run(const Row& row, std::size_t begin, std::size_t end) const {
  kernels_.adam({row.values, row.first, row.second, row.gradient, row.chosen,
                 static_cast<float>(row.rate * correction1_), static_cast<float>(correction2_),
                 static_cast<float>(constants_.beta1), static_cast<float>(constants_.beta2),
                 static_cast<float>(constants_.epsilon)},
                begin, end);
}

void adam_step(PlanarFloats& parameters, AdamState& state, const PlanarFloats& gradient,
               const std::vector<std::uint8_t>& visible, const LearningRates& rates,
               const AdamStep& adam, RowRange rows, const Threads& threads) {
  threads.for_pieces(parameters.size(), kAdamPiece, [&](std::size_t begin, std::size_t end) {
    for (int r = rows.first; r < rows.end; ++r)
      adam.run({parameters.row(r), state.first.row(r), state.second.row(r), gradient.row(r),
                visible.data(), rate_of(rates, r)},
               begin, end);
  });
}

}  // namespace fluxgs
