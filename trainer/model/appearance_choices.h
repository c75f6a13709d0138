// What can be chosen about appearance, by the names of the command line. Nothing of ours is
// included, so that the options of training may hold these types.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace fluxgs {

/// How splats of degree 3 become splats of a lower degree.
enum class ShReduction {
  view_ls,     ///< least squares over the directions from which each splat is seen (sh_reduction.h)
  truncate,    ///< the higher bands are dropped
  uniform_ls,  ///< least squares over the whole sphere: truncation, but for the quadrature's error
  energy,      ///< the paper's: a network on the moments of energy_moments.h
  none         ///< no reduction: the target degree is trained from the beginning
};
inline constexpr std::array<std::string_view, 5> kShReductionNames = {
    "view-ls", "truncate", "uniform-ls", "energy", "none"};

/// Of which part of the colour the energy moments are taken: degree 3 less a lower degree.
enum class Residual {
  from_1,  ///< bands 2 and 3
  from_2,  ///< band 3 alone, as the paper has it: its E_dir is zero (energy_moments.h)
  from_0   ///< bands 1, 2 and 3
};
inline constexpr std::array<std::string_view, 3> kResidualNames = {"3-1", "3-2", "3-0"};

/// How means over the sphere are approximated (quadrature.h).
enum class Quadrature { fibonacci, lebedev, mc };
inline constexpr std::array<std::string_view, 3> kQuadratureNames = {"fibonacci", "lebedev", "mc"};

inline constexpr std::string_view name_of(Quadrature q) {
  return kQuadratureNames[static_cast<std::size_t>(q)];
}

}  // namespace fluxgs
