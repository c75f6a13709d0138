// Images of each group of a sweep's rows.
#pragma once

#include "tools/fluxgs/plot.h"
#include "tools/fluxgs/sweep_table.h"

namespace fluxgs::cli {

/// PSNR against the option that the group changes, or else PSNR of the compact scene against its
/// size, with bars of one standard deviation. Of the mean over all scenes, or the only one.
Plot sweep_plot(const SweepTable& table, const SweepGroup& group);

/// PSNR of the test images over the training, a line for each row of the group: the mean of its
/// finished runs where all of them have measured. What is far below the best is cut off.
Plot sweep_curves(const SweepTable& table, const SweepGroup& group);

}  // namespace fluxgs::cli
