// A palette for vectors: each takes the nearest of some thousands of entries.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace fluxgs::io {

struct ShPalette {
  std::vector<float> entries;         ///< [entry][dimension], entries alike lie near one another
  std::vector<std::uint32_t> labels;  ///< of each vector its entry
};

/// A palette of at most `most` entries with little mean squared error: the cell with the largest
/// error is split across its principal axis until there are enough (Wu & Witten 1985), then
/// Lloyd's iteration moves vectors between cells that lie near one another. The time grows as
/// vectors · dimensions · log entries. The same vectors always give the same palette. `progress`
/// hears parts of the work, 0…1.
ShPalette make_sh_palette(std::span<const float> vectors, std::size_t dimensions, std::size_t most,
                          const std::function<void(double)>& progress);

}  // namespace fluxgs::io
