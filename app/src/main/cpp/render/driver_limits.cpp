#include "render/driver_limits.h"

namespace fluxgs::render {
namespace {

constexpr std::string_view kNoGpuSort = "no_gpu_sort", kNoVertexStorage = "no_vertex_storage",
                           kNoFloatTargets = "no_float_targets", kNoCompute = "no_compute",
                           kNoFragmentProjection = "no_fragment_projection";

}  // namespace

std::vector<std::string> DriverLimits::names() const {
  std::vector<std::string> set;
  if (no_gpu_sort) set.emplace_back(kNoGpuSort);
  if (no_vertex_storage) set.emplace_back(kNoVertexStorage);
  if (no_float_targets) set.emplace_back(kNoFloatTargets);
  if (no_compute) set.emplace_back(kNoCompute);
  if (no_fragment_projection) set.emplace_back(kNoFragmentProjection);
  return set;
}

DriverLimits limits_named(std::string_view names) {
  return {.no_gpu_sort = names.contains(kNoGpuSort),
          .no_vertex_storage = names.contains(kNoVertexStorage),
          .no_float_targets = names.contains(kNoFloatTargets),
          .no_compute = names.contains(kNoCompute),
          .no_fragment_projection = names.contains(kNoFragmentProjection)};
}

void apply(const DriverLimits& limits, gl::Api& api) {
  gl::Capabilities& has = api.capabilities;
  if (limits.no_gpu_sort) api.quirks.gpu_sort_fails = true;
  if (limits.no_vertex_storage) has.max_vertex_storage_blocks = 0;
  if (limits.no_float_targets) has.float_targets = has.half_float_targets = false;
  if (limits.no_compute) has.compute = false;
  if (limits.no_fragment_projection) api.quirks.fragment_projection_fails = true;
}

}  // namespace fluxgs::render
