#include "trainer/compress/size_search.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "trainer/compress/compact_search.h"

namespace fluxgs {
namespace {

constexpr double kFewestBits = 12;      // of a splat: with fewer, fewer splats are better
constexpr double kFewer = 0.8;          // splats of the next look
constexpr double kMuchFewer = 0.5;      // the same, where nothing fits
constexpr int kWorseLooks = 2;          // after the best, one behind the other
constexpr std::size_t kUsualLooks = 7;  // for the progress

std::size_t part_of(std::size_t count, double share) {
  return std::max<std::size_t>(1, static_cast<std::size_t>(static_cast<double>(count) * share));
}

/// The progress of each look: the first takes most splats away.
ProgressParts parts_of_looks(const ProgressReport& progress) {
  std::vector<double> shares(kUsualLooks, 1);
  shares.front() = 4;
  return {progress, std::move(shares)};
}

}  // namespace

Expected<SizedScene> splats_within_bytes(SceneReduction& reduction, const SceneError& error,
                                         CompactOptions start, const SizeLimit& limit,
                                         const WorkControl& control) {
  const ProgressParts parts = parts_of_looks(control.progress);
  std::optional<SizedScene> best;
  std::size_t count = std::min(reduction.size(), part_of(limit.bytes, 8 / kFewestBits));
  int worse = 0;
  for (std::size_t look = 0;; ++look) {
    const ProgressReport progress = look < kUsualLooks ? parts.part(look) : ProgressReport();
    reduction.reduce(count, {progress, control.stop});
    if (control.stopped()) return fail("", "", "stopped");
    SplatCloud cloud = reduction.cloud();
    auto found = CompactSearch(cloud, error, start).first_within_bytes(limit.bytes, limit.beside);
    if (found && (!best || found->mse < best->mse)) {
      start.steps = found->options.steps;
      best = SizedScene{std::move(cloud), found->options.steps, found->mse};
      worse = 0;
    } else if (best) {
      ++worse;
    }
    if (best && (worse == kWorseLooks || best->mse <= kInvisibleMse || count == 1)) break;
    if (!found && count == 1) return std::unexpected(found.error());
    count = part_of(count, found ? kFewer : kMuchFewer);
  }
  return std::move(*best);
}

}  // namespace fluxgs
