#include "trainer/train/progressive_resolution.h"

#include <cmath>

#include <fmt/format.h>

#include "trainer/data/pyramid.h"

namespace fluxgs {
namespace {

class ProgressiveResolution final : public Phase {
 public:
  ProgressiveResolution(const ProgressiveResolutionOptions& options, int iterations,
                        const std::vector<View>& views)
      : options_(options), iterations_(iterations), pyramid_(views, options.levels) {}

  const char* name() const override { return "progressive resolution"; }
  Period period() const override { return {.from = 1, .until = options_.until}; }
  std::string effect() const override {
    return fmt::format("trains on images halved {} at the start",
                       options_.levels == 1 ? "once" : fmt::format("{} times", options_.levels));
  }
  std::string warning() const override {
    if (options_.until < iterations_) return {};
    return fmt::format("images stay halved to the end: --resolution-until {} of {} iterations",
                       options_.until, iterations_);
  }
  void begin(Training& t) override { t.views = &pyramid_.at(level(t.state.iteration)); }
  double pixel_share(int iteration) const override { return std::pow(0.25, level(iteration - 1)); }

 private:
  /// Each size for the same number of iterations. `done`: iterations.
  int level(int done) const {
    const int left = options_.until - done;
    return left <= 0 ? 0
                     : static_cast<int>(
                           std::ceil(static_cast<double>(options_.levels) * left / options_.until));
  }

  ProgressiveResolutionOptions options_;
  int iterations_;
  ViewPyramid pyramid_;
};

}  // namespace

OptionFields ProgressiveResolutionOptions::fields(const TrainOptions&) {
  return {whole("resolution-levels", "number of times training images are halved at the start",
                levels, 0, 4),
          whole("resolution-until",
                "iteration of the first full-size images (0: 3/10 of the iterations)", until, 0,
                kUnlimited)
              .only_if(levels > 0, "--resolution-levels 1 or more")};
}

std::unique_ptr<Phase> make_progressive_resolution(TrainOptions& options,
                                                   const std::vector<View>& views) {
  auto& own = options.get<ProgressiveResolutionOptions>();
  if (own.levels == 0) return nullptr;
  resolve(own.until, options.iterations / 10 * 3);
  return std::make_unique<ProgressiveResolution>(own, options.iterations, views);
}

}  // namespace fluxgs
