#include "trainer/model/adam.h"

#include <cmath>

namespace fluxgs {
namespace {

constexpr std::size_t kPiece = 2048;  // splats

double rate_of(const LearningRates& rates, int r) {
  if (r < row::log_scale) return rates.position;
  if (r < row::rotation) return rates.log_scale;
  if (r < row::opacity) return rates.rotation;
  if (r < row::sh_dc) return rates.opacity;
  return r < row::sh_rest ? rates.sh_dc : rates.sh_rest;
}

}  // namespace

AdamStep::AdamStep(const AdamConstants& constants, int step)
    : constants_(constants),
      correction1_(1 / (1 - std::pow(constants.beta1, step))),
      correction2_(1 / (1 - std::pow(constants.beta2, step))) {}

AdamArgs AdamStep::args(float* values, float* first, float* second, const float* gradient,
                        const std::uint8_t* chosen, double rate) const {
  return {values,
          first,
          second,
          gradient,
          chosen,
          static_cast<float>(rate * correction1_),
          static_cast<float>(correction2_),
          static_cast<float>(constants_.beta1),
          static_cast<float>(constants_.beta2),
          static_cast<float>(constants_.epsilon)};
}

void adam_step(PlanarFloats& parameters, AdamState& state, const PlanarFloats& gradient,
               const std::vector<std::uint8_t>& visible, const LearningRates& rates,
               const AdamConstants& constants, int step, int first_row, int end_row,
               const Threads& threads, const AdamKernels& kernels) {
  const AdamStep adam(constants, step);
  threads.for_pieces(parameters.size(), kPiece, [&](std::size_t begin, std::size_t end) {
    for (int r = first_row; r < end_row; ++r)
      kernels.adam(adam.args(parameters.row(r), state.first.row(r), state.second.row(r),
                             gradient.row(r), visible.data(), rate_of(rates, r)),
                   begin, end);
  });
}

}  // namespace fluxgs
