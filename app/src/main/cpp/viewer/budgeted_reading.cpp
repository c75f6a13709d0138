#include "viewer/budgeted_reading.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "fluxgs/contribution.h"

namespace fluxgs::viewer {
namespace {

using render::RenderCloud;
using Planned = std::function<void(const ComingSplats&, const ScenePlan&)>;
using Coarse = std::function<void(LoadedScene&&)>;

constexpr std::size_t kLeastPart = 20;  // of the splats, below which it is not the scene

std::string megabytes(std::uint64_t bytes) {
  constexpr double kMegabyte = 1e6;
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) / kMegabyte);
}

/// Which splats are among those that add most, in the order of the file; of equal ones the first.
class Ranking {
 public:
  void add(double contribution) { values_.push_back(static_cast<float>(contribution)); }
  std::size_t size() const { return values_.size(); }

  /// Chooses so many. To be called once all are there.
  void choose(std::size_t count) {
    if (count >= values_.size()) return;
    std::vector<float> sorted = values_;
    const auto last = sorted.begin() + static_cast<std::ptrdiff_t>(count) - 1;
    std::nth_element(sorted.begin(), last, sorted.end(), std::greater());
    least_ = *last;
    equal_ = static_cast<std::size_t>(std::count(sorted.begin(), last + 1, least_));
  }

  /// To be asked about all of them one after the other.
  bool is_chosen(std::size_t i) {
    if (values_[i] != least_) return values_[i] > least_;
    if (equal_ == 0) return false;
    --equal_;
    return true;
  }

 private:
  std::vector<float> values_;
  float least_ = -1;       // contributions are not negative
  std::size_t equal_ = 0;  // of those that add this, how many are still to be chosen
};

/// Keeps what fits. Where that is not all, the first reading ranks the splats, and the second one
/// keeps those that add most.
class BudgetSink final : public SplatSink {
 public:
  BudgetSink(std::uint64_t memory, const std::string& name, const Planned& planned,
             const Coarse& coarse)
      : memory_(memory), name_(name), planned_(planned), coarse_(coarse) {}

  Expected<int> begin(const ComingSplats& coming) override {
    if (ranked_ && coming.count != coming_) return changed();
    coming_ = coming.count;
    plan_ = plan_scene(coming, memory_);
    const ScenePlan& plan = plan_;
    const bool is_enough = plan.count >= (coming.count + kLeastPart - 1) / kLeastPart;
    if (coming.held > memory_ || !is_enough) return too_large(coming);
    planned_(coming, plan);
    cloud_.sh_degree = plan.sh_degree;
    cloud_.file_sh_degree = coming.sh_degree;
    keeps_ = ranked_ || plan.count == coming.count;
    if (keeps_) reserve(cloud_, plan.count);
    return plan.sh_degree;
  }

  Expected<void> take(SplatCloud& part) override {
    if (keeps_ && ranked_ && cloud_.file_splats + part.size() > ranking_.size()) return changed();
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (!keeps_)
        ranking_.add(contribution(part, i));
      else if (!ranked_ || ranking_.is_chosen(cloud_.file_splats + i))
        append(part, i, cloud_);
    }
    if (keeps_) cloud_.file_splats += part.size();
    return {};
  }

  void chunk_came(const SceneFile& so_far) override {
    const std::uint64_t all = plan_.count * render::render_cloud_bytes(plan_.sh_degree);
    if (!coarse_ || !keeps_ || ranked_ || !so_far.start || 2 * all > memory_) return;
    LoadedScene scene{cloud_, so_far.dropped, so_far.start, true};
    scene.cloud.file_splats = coming_;
    scene.cloud.base.filter = so_far.cloud.filter;
    put_in_order(scene.cloud);
    coarse_(std::move(scene));
  }

  bool needs_second_reading() const { return !keeps_; }
  void start_second_reading() {
    ranked_ = true;
    ranking_.choose(plan_.count);
  }

  RenderCloud finish(const ScreenFilter& filter) {
    cloud_.base.filter = filter;
    return std::move(cloud_);
  }

 private:
  std::unexpected<Error> changed() const {
    return fail(name_, "read", "has changed while it was read");
  }
  std::unexpected<Error> too_large(const ComingSplats& coming) const {
    const std::uint64_t least =
        render::render_cloud_bytes(std::min(coming.sh_degree, 1)) * coming.count / kLeastPart;
    return needs_memory(name_, std::max(coming.held, least), memory_);
  }

  std::uint64_t memory_;
  const std::string& name_;
  const Planned& planned_;
  const Coarse& coarse_;
  ScenePlan plan_;
  std::size_t coming_ = 0;
  bool keeps_ = false, ranked_ = false;
  Ranking ranking_;
  RenderCloud cloud_;
};

}  // namespace

std::unexpected<Error> needs_memory(const std::string& name, std::uint64_t needed,
                                    std::uint64_t allowed) {
  return fail(name, "memory",
              fmt::format("needs about {}, but only {} may be used", megabytes(needed),
                          megabytes(allowed)));
}

ScenePlan plan_scene(const ComingSplats& coming, std::uint64_t memory) {
  constexpr std::uint64_t kRanked = 2 * sizeof(float);
  const auto fit = [&](int sh_degree) {
    const std::uint64_t each = render::render_cloud_bytes(sh_degree);
    if (coming.count <= memory / each) return coming.count;
    const std::uint64_t ranking = std::min(memory, kRanked * coming.count);
    return static_cast<std::size_t>((memory - ranking) / each);
  };
  const std::size_t count = fit(std::min(coming.sh_degree, 1));
  int degree = coming.sh_degree;
  while (degree > 1 && fit(degree) < count) --degree;
  return {count, degree};
}

Expected<LoadedScene> read_within(std::uint64_t memory, const SceneFormat& format,
                                  const ByteSource& source, const std::string& name,
                                  const std::function<void(const SceneEstimate&)>& planned,
                                  const std::function<void()>& second, const Coarse& coarse) {
  const Planned tell = [&](const ComingSplats& coming, const ScenePlan& plan) {
    if (planned)
      planned({.format = std::string(format.name),
               .splats = coming.count,
               .sh_degree = coming.sh_degree,
               .decoded = plan.count * render::render_cloud_bytes(plan.sh_degree)});
  };
  BudgetSink sink(memory, name, tell, coarse);
  auto read = read_scene(format, source, name, sink);
  if (read && sink.needs_second_reading()) {
    if (second) second();
    sink.start_second_reading();
    read = read_scene(format, source, name, sink);
  }
  if (!read) return std::unexpected(read.error());
  LoadedScene scene{sink.finish(read->cloud.filter), read->dropped, read->start};
  put_in_order(scene.cloud);
  return scene;
}

}  // namespace fluxgs::viewer
