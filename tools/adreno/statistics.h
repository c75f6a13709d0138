// Statistics of a shader by Mesa's compiler for Adreno, parsed from the output of
// adreno_statistics.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "fluxgs/error.h"

namespace fluxgs::adreno {

/// One shader as one GPU would run it. The numbers are those of Mesa's shader-db lines
/// (src/freedreno/ir3/ir3_shader.c); stalls are the compiler's estimate in cycles.
struct ShaderStatistics {
  std::string program;   ///< as in shaders/programs.cmake
  std::string stage;     ///< compute, vertex, binning (the vertex shader for tiles) or fragment
  int instructions = 0;  ///< all of them
  int without_nops = 0;  ///< those that are no waiting
  int half_registers = 0, full_registers = 0;
  int waves = 0;         ///< at once on a core: 16 is all
  int short_stalls = 0;  ///< (ss): waiting for special functions and shared memory
  int long_stalls = 0;   ///< (sy): waiting for textures and memory
  int spills = 0;        ///< stores to and loads from memory for want of registers
  int shared_bytes = 0;  ///< shared memory of a work group; 0 but for compute
};

struct GpuStatistics {
  std::string gpu;   ///< a630, a740, …
  std::string mesa;  ///< the driver's version, e.g. 26.1.6-1~bpo13+1
  std::vector<ShaderStatistics> shaders;
};

/// Reads the output of adreno_statistics, in which the driver's own lines are. Fails, naming the
/// line or program, where a program has no statistics, or not those of its stages, and where the
/// driver is not that of an Adreno.
Expected<GpuStatistics> parse_statistics(std::string_view log, const std::string& file);

}  // namespace fluxgs::adreno
