#include "trainer/model/phase.h"

#include <algorithm>
#include <span>

namespace fluxgs {

bool Period::due(int iteration) const {
  if (interval == 0) return iteration == from;
  return iteration >= from && iteration <= until && iteration % interval == 0;
}

int Period::first() const {
  return interval == 0 ? from : (std::max(from, 1) + interval - 1) / interval * interval;
}

bool Period::takes_place(int iterations) const {
  return first() <= (interval == 0 ? iterations : std::min(until, iterations));
}

void Training::exchange_opacities() {
  std::ranges::swap_ranges(true_opacities,
                           std::span(state.parameters.row(row::opacity), true_opacities.size()));
}

}  // namespace fluxgs
