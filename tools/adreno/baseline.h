// The numbers that are to be kept: a JSON file in the repository, and what became worse than it.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "tools/adreno/statistics.h"

namespace fluxgs::adreno {

/// One line a shader, so that a change of the file shows what changed. `gpus` must not be empty and
/// be of one version of Mesa.
std::string to_json(std::span<const GpuStatistics> gpus);

/// The other way round. Fails, naming the key, on anything else.
Expected<std::vector<GpuStatistics>> from_json(const std::string& text, const std::string& file);

/// One line for everything in `now` that is not as good as in `baseline`: instructions (with and
/// without nops), registers or stalls beyond 5% more and at least 2 more; fewer waves; any spill; a
/// shader that only one of them has. GPUs that are not in `now` are not looked at.
std::vector<std::string> regressions(std::span<const GpuStatistics> baseline,
                                     std::span<const GpuStatistics> now);

/// True if both come from the same release of Mesa, e.g. 26.1.6, whatever the package's revision:
/// numbers of different compilers say nothing about a change of ours.
bool same_compiler(const GpuStatistics& a, const GpuStatistics& b);

}  // namespace fluxgs::adreno
