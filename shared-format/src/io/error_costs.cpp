#include "fluxgs/io/error_costs.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "io/gather.h"

namespace fluxgs {
namespace {

/// Lower triangles whose diagonals are to be `positive`, or at least not negative.
Expected<void> check_triangles(const std::vector<float>& numbers, std::size_t rows, bool positive,
                               std::size_t splats, const std::string& name, const char* what) {
  if (numbers.empty()) return {};
  const std::size_t each = rows * (rows + 1) / 2;
  if (numbers.size() != each * splats)
    return fail(
        name, what,
        fmt::format("{} numbers, expected {} for each of {} splats", numbers.size(), each, splats));
  for (std::size_t i = 0; i < splats; ++i)
    for (std::size_t row = 0, at = i * each; row < rows; ++row, at += row + 1)
      if (!(numbers[at] >= 0) || (positive && numbers[at] == 0))
        return fail(name, what,
                    fmt::format("splat {} has {} on its diagonal, expected {}", i, numbers[at],
                                positive ? "more than 0" : "0 or more"));
  if (!std::ranges::all_of(numbers, [](float v) { return std::isfinite(v); }))
    return fail(name, what, "have a number that is not finite");
  return {};
}

}  // namespace

ErrorCosts costs_of(const ErrorCosts& costs, int sh_degree, std::span<const std::uint32_t> splats,
                    int new_degree) {
  return {.weights = io::gather(costs.weights, splats, 1, 1),
          .sh_factors = io::gather(costs.sh_factors, splats, sh_factor_size(sh_degree),
                                   sh_factor_size(new_degree)),
          .scale = io::gather(costs.scale, splats, kTriangle3, kTriangle3),
          .rotation = io::gather(costs.rotation, splats, kTriangle3, kTriangle3)};
}

Expected<void> check_costs(const ErrorCosts& costs, const SplatCloud& cloud,
                           const std::string& name) {
  if (!costs.weights.empty() && costs.weights.size() != cloud.size())
    return fail(name, "weights",
                fmt::format("{} of them, expected one for each of {} splats", costs.weights.size(),
                            cloud.size()));
  const auto functions = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree) + 1);
  if (auto ok = check_triangles(costs.sh_factors, functions, true, cloud.size(), name,
                                "factors of SH coefficients");
      !ok)
    return ok;
  if (auto ok = check_triangles(costs.scale, 3, false, cloud.size(), name, "costs of scales"); !ok)
    return ok;
  return check_triangles(costs.rotation, 3, false, cloud.size(), name, "costs of rotations");
}

}  // namespace fluxgs
