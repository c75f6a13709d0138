#include "seeds.h"

#include <cstdlib>

namespace fluxgs::fuzz {

Seeds make_seeds() {
  Seeds seeds;
  add_own_seeds(seeds);
  if (const char* data = std::getenv("FLUXGS_DATA")) add_real_seeds(seeds, data);
  seeds["compact_stability"] = seeds["stability"];
  return seeds;
}

}  // namespace fluxgs::fuzz
