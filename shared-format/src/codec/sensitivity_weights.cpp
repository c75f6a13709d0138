#include "fluxgs/io/sensitivity_weights.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cloud/gather.h"

namespace fluxgs {
namespace {

/// Lower triangles whose diagonals are to be `positive`, or at least not negative.
Expected<void> check_matrices(const std::vector<float>& values, std::size_t rows, bool positive,
                              std::size_t splats, const std::string& name, const char* what) {
  if (values.empty()) return {};
  const std::size_t each = rows * (rows + 1) / 2;
  if (values.size() != each * splats)
    return fail(
        name, what,
        fmt::format("{} values, expected {} for each of {} splats", values.size(), each, splats));
  for (std::size_t i = 0; i < splats; ++i)
    for (std::size_t row = 0, at = i * each; row < rows; ++row, at += row + 1)
      if (!(values[at] >= 0) || (positive && values[at] == 0))
        return fail(name, what,
                    fmt::format("splat {} has {} on its diagonal, expected {}", i, values[at],
                                positive ? "more than 0" : "0 or more"));
  if (!std::ranges::all_of(values, [](float v) { return std::isfinite(v); }))
    return fail(name, what, "have a value that is not finite");
  return {};
}

}  // namespace

SensitivityWeights sensitivity_of(const SensitivityWeights& sensitivity, int sh_degree,
                                  std::span<const std::uint32_t> splats, int new_degree) {
  return {.weights = io::gather(sensitivity.weights, splats, 1, 1),
          .sh_factors = io::gather(sensitivity.sh_factors, splats, sh_factor_size(sh_degree),
                                   sh_factor_size(new_degree)),
          .scale = io::gather(sensitivity.scale, splats, kSymmetric3, kSymmetric3),
          .rotation = io::gather(sensitivity.rotation, splats, kSymmetric3, kSymmetric3)};
}

Expected<void> check_sensitivity(const SensitivityWeights& sensitivity, const SplatCloud& cloud,
                                 const std::string& name) {
  if (!sensitivity.weights.empty() && sensitivity.weights.size() != cloud.size())
    return fail(name, "weights",
                fmt::format("{} of them, expected one for each of {} splats",
                            sensitivity.weights.size(), cloud.size()));
  const auto functions = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree) + 1);
  if (auto ok = check_matrices(sensitivity.sh_factors, functions, true, cloud.size(), name,
                               "factors of SH coefficients");
      !ok)
    return ok;
  if (auto ok = check_matrices(sensitivity.scale, 3, false, cloud.size(), name, "costs of scales");
      !ok)
    return ok;
  return check_matrices(sensitivity.rotation, 3, false, cloud.size(), name, "costs of rotations");
}

}  // namespace fluxgs
