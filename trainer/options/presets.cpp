#include <algorithm>

#include <fmt/format.h>

#include "trainer/options/options.h"

namespace fluxgs {

std::vector<std::string> preset_names() { return {"3dgs"}; }

Expected<TrainOptions> preset(std::string_view name) {
  if (name == "3dgs") return TrainOptions{};
  return fail("", "--preset", fmt::format("'{}' is not a preset; expected 3dgs", name));
}

TrainOptions resolved(TrainOptions options) {
  const auto otherwise = [](int& value, int alternative) {
    if (value == 0) value = std::max(alternative, 1);
  };
  const int n = options.iterations;
  otherwise(options.switch_iteration,
            options.sh_target == ShTarget::adaptive ? n / 10 * 7 : std::min(n / 10, 3000));
  // A quarter of the time before the switch is for the highest degree
  otherwise(options.sh_degree_interval,
            std::min({n / 8 + 1, 1000, std::max(options.switch_iteration / 4, 1)}));
  otherwise(options.densify_until, std::min(n / 2, 15000));
  otherwise(options.coarse_until, n / 10 * 3);
  otherwise(options.late_prune_from, n / 5 * 3);
  otherwise(options.late_prune_interval, n / 10);
  otherwise(options.late_prune_until, n / 10 * 9);
  return options;
}

}  // namespace fluxgs
