// Rounding to whole numbers that take few bits: not always the nearest one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fluxgs::codec {

/// What rounding weighs against each other: weight·(error)² + bits·rate_weight is made small, where
/// the error is in steps. 0 rounds to the nearest.
struct Rounding {
  double rate_weight = 0;
  std::span<const float> weights = {};  ///< one for each value, 1 on the average; empty: all 1
};

/// Whole numbers for `values` as what is coded: themselves or, if `predicted`, their differences
/// from the prediction by those before. Each is the nearest or the one next to it towards the
/// cheaper zero, so that it is off by 1.5 at most; which of the two depends on how often the
/// numbers occur. |values| < 2²⁸.
std::vector<std::int32_t> round_cheaply(std::span<const double> values, bool predicted,
                                        const Rounding& rounding);

}  // namespace fluxgs::codec
