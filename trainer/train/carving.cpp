#include "trainer/train/carving.h"

#include <algorithm>

namespace fluxgs {
namespace {

bool is_transparent(const View& view) { return !view.alpha.pixels.empty(); }

class Carving final : public Phase {
 public:
  explicit Carving(int iterations) : iterations_(iterations) {}

  const char* name() const override { return "carving"; }
  PlanRow plan() const override {
    return {.from = 1,
            .until = iterations_,
            .what = "puts photos with transparent parts, and renders, over random backgrounds"};
  }
  void begin(Training& t) override {
    for (int c = 0; c < 3; ++c) background_[c] = uniform(t.state.random);
  }
  /// Scores of splats, too, are taken over this background.
  void configure(RenderOptions& render, const TrainState&) const override {
    render.background = background_;
  }
  void before_render(Training& t) override {
    if (!is_transparent(*t.view)) t.render.background = t.options.render.background;
  }

 private:
  int iterations_;
  glm::dvec3 background_{0};
};

}  // namespace

OptionFields MaskOptions::fields(const TrainOptions&) {
  return {choice("masks",
                 "use of masks, black where masked, and of transparency (auto: ignore what masks "
                 "cover, carve what is transparent)",
                 masks, kMaskUseNames)};
}

std::unique_ptr<Phase> make_carving(const TrainOptions& options, const std::vector<View>& views) {
  if (std::ranges::none_of(views, is_transparent)) return nullptr;
  return std::make_unique<Carving>(options.iterations);
}

}  // namespace fluxgs
