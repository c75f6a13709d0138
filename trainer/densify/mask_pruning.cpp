#include "trainer/densify/mask_pruning.h"

#include <algorithm>

#include "trainer/raster/score.h"

namespace fluxgs {
namespace {

bool has_mask(const View& view) { return !view.used.pixels.empty(); }

class MaskPruning final : public Phase {
 public:
  explicit MaskPruning(int iterations) : iterations_(iterations) {}

  const char* name() const override { return "mask pruning"; }
  /// Splats come to be in the first half of a run; then there is room for the values of the file.
  Period period() const override {
    const int fifth = std::max(iterations_ / 5, 1);
    return {.from = fifth, .until = 4 * fifth, .interval = fifth};
  }
  std::string effect() const override {
    return "removes splats that are seen in masked parts of photos only";
  }
  bool reports(int iteration) const override { return period().due(iteration); }
  PhaseWork work(int iteration, std::size_t views) const override {
    return {.renders = reports(iteration) ? 1.5 * static_cast<double>(views) : 0};
  }
  std::optional<PhaseReport> after_step(Training& t) override {
    if (!period().due(t.state.iteration)) return {};
    t.complete_colors();
    apply_refinement(
        t.state, t.options,
        masked_splats(t.data.train, t.state.parameters, t.render_options(), t.rasterizer));
    return PhaseReport();
  }

 private:
  int iterations_;
};

}  // namespace

std::vector<RefineAction> masked_splats(const std::vector<View>& views,
                                        const PlanarFloats& parameters, const RenderOptions& render,
                                        Rasterizer& rasterizer) {
  const std::size_t count = parameters.size();
  std::vector<double> counted(count), all(count);
  for (const View& view : views) {
    rasterizer.forward(parameters, view.camera, render);
    PlanarImage maps(view.camera.width, view.camera.height, 2);
    if (has_mask(view)) copy_mask(view.used, maps, 0);
    const PlanarFloats& scores = rasterizer.score(maps, ScoreWeight::alpha_transmittance);
    const float* sums = scores.row(score::contribution);
    const float* inside = has_mask(view) ? scores.row(score::first) : sums;
    for (std::size_t i = 0; i < count; ++i) {
      counted[i] += static_cast<double>(inside[i]);
      all[i] += static_cast<double>(sums[i]);
    }
  }
  std::vector<RefineAction> actions(count, RefineAction::keep);
  for (std::size_t i = 0; i < count; ++i)
    if (counted[i] < kLeastCounted * all[i]) actions[i] = RefineAction::prune;
  return actions;
}

std::unique_ptr<Phase> make_mask_pruning(const TrainOptions& options,
                                         const std::vector<View>& views) {
  if (std::ranges::none_of(views, has_mask)) return nullptr;
  return std::make_unique<MaskPruning>(options.iterations);
}

}  // namespace fluxgs
