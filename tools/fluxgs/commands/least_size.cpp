#include "tools/fluxgs/commands/least_size.h"

namespace fluxgs::cli {

Expected<LeastSize> least_size(const SplatCloud& cloud, const std::optional<InitialView>& start,
                               const CompactOptions& options) {
  constexpr const char* kName = "one splat";
  constexpr std::size_t kAlignment = 3;  // glTF pads to four bytes
  SplatCloud one;
  one.sh_degree = cloud.sh_degree;
  one.filter = cloud.filter;
  one.resize(1);
  one.rotations[0] = {1, 0, 0, 0};
  const auto file = encode_compact_glb(one, options, kName);
  if (!file) return std::unexpected(file.error());
  if (!start) return LeastSize{.start = 0, .one_splat = file->size()};
  const auto with_start = with_initial_view(*file, *start, kName);
  if (!with_start) return std::unexpected(with_start.error());
  return LeastSize{.start = with_start->size() - file->size() + kAlignment,
                   .one_splat = with_start->size()};
}

}  // namespace fluxgs::cli
