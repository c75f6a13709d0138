#include "trainer/train/carving.h"

#include <algorithm>
#include <cmath>

#include "trainer/raster/rasterizer.h"

namespace fluxgs {
namespace {

bool is_transparent(const View& view) { return !view.alpha.pixels.empty(); }

class Carving final : public Phase {
 public:
  Carving(int iterations, double alpha_loss) : iterations_(iterations), alpha_loss_(alpha_loss) {}

  const char* name() const override { return "carving"; }
  Period period() const override { return {.from = 1, .until = iterations_}; }
  std::string effect() const override {
    return "puts photos with transparent parts, and renders, over random backgrounds";
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
  void before_backward(Training& t) override {
    if (alpha_loss_ <= 0 || !is_transparent(*t.view)) return;
    alpha_loss_gradient(t.rasterizer.transmittance(), t.view->alpha, t.view->used, alpha_loss_,
                        t.threads, gradient_);
    t.transmittance_gradient = &gradient_;
  }

 private:
  int iterations_;
  double alpha_loss_;
  PlanarImage gradient_;
  glm::dvec3 background_{0};
};

}  // namespace

OptionFields MaskOptions::fields(const TrainOptions&) {
  return {choice("masks",
                 "what black in masks and transparency of photos mean (auto: ignore what is black, "
                 "keep the scene empty where photos are transparent)",
                 masks, kMaskUseNames),
          real("alpha-loss", "weight of the difference of opacities where photos are carved",
               alpha_loss, 0, 10)};
}

void alpha_loss_gradient(const PlanarImage& transmittance, const Image<std::uint8_t>& alpha,
                         const Image<std::uint8_t>& used, double weight, const Threads& threads,
                         PlanarImage& out) {
  constexpr float kSame = 0.5f / 255;
  const int width = transmittance.width(), height = transmittance.height();
  if (out.width() != width || out.height() != height) out = PlanarImage(width, height, 1);
  const auto step = static_cast<float>(weight / (static_cast<double>(width) * height));
  constexpr std::size_t kRows = 32;
  const auto fill = [&](int y) {
    const float* t = transmittance.row(0, y);
    float* g = out.row(0, y);
    for (int x = 0; x < width; ++x) {
      const bool counts = used.pixels.empty() || *used.at(x, y) != 0;
      const float more = 1 - t[x] - static_cast<float>(*alpha.at(x, y)) / 255;
      g[x] = counts && std::abs(more) > kSame ? std::copysign(step, -more) : 0;
    }
  };
  threads.for_pieces(static_cast<std::size_t>(height), kRows,
                     [&](std::size_t begin, std::size_t end) {
                       for (std::size_t y = begin; y < end; ++y) fill(static_cast<int>(y));
                     });
}

std::unique_ptr<Phase> make_carving(const TrainOptions& options, const std::vector<View>& views) {
  if (std::ranges::none_of(views, is_transparent)) return nullptr;
  return std::make_unique<Carving>(options.iterations, options.get<MaskOptions>().alpha_loss);
}

}  // namespace fluxgs
