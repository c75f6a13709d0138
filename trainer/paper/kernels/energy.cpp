// A pack of splats at a time; their coefficients stay in registers or the first cache while the
// directions go by, so nothing of the size splats × directions is ever stored.
#include "trainer/core/lanes.h"
#include "trainer/paper/energy_kernels.h"

namespace fluxgs::FLUXGS_ISA {
namespace {

void energy_pack(const EnergyArgs& args, std::size_t i) {
  Lanes coefficients[15];
  Lanes unsound(0.0f);  // NaN where a coefficient is not finite
  for (int k = args.first; k < args.end; ++k) {
    coefficients[k] = Lanes::load(args.coefficients[k] + i);
    unsound += coefficients[k] - coefficients[k];
  }
  const Lanes zero(0.0f);
  Lanes sums[4] = {unsound, unsound, unsound, unsound};
  for (std::size_t s = 0; s < args.sample_count; ++s) {
    const EnergySample& sample = args.samples[s];
    Lanes f = zero;
    for (int k = args.first; k < args.end; ++k) f = fma(Lanes(sample.basis[k]), coefficients[k], f);
    f = max(f, zero);
    for (int m = 0; m < 4; ++m) sums[m] = fma(Lanes(sample.moments[m]), f, sums[m]);
  }
  for (int m = 0; m < 4; ++m)
    zero_unless(sums[m] - sums[m] == zero, sums[m]).store(args.moments[m] + i);
}

}  // namespace

void energy(const EnergyArgs& args, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; i += static_cast<std::size_t>(kLanes)) energy_pack(args, i);
}

extern const EnergyKernels kEnergyKernels;
const EnergyKernels kEnergyKernels{energy};

}  // namespace fluxgs::FLUXGS_ISA
