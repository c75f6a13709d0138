#include "trainer/densify/dropout.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fluxgs/math/logistic.h"
#include "trainer/data/dataset.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {
namespace {

constexpr double kMaxHidden = 0.2;  // as the authors use
constexpr float kHidden = -30;      // a logit far below what is drawn

/// The logit of `scale` × the opacity of another, up to kOpaque; opaquer ones stay as they are.
float magnified(float opacity_logit, float scale) {
  const float opacity = sigmoid(opacity_logit), most = static_cast<float>(kOpaque);
  if (opacity >= most) return opacity_logit;
  const float more = std::min(opacity * scale, most);
  return more > 0 ? logit(more) : opacity_logit;
}

class Dropout final : public Phase {
 public:
  Dropout(double dropout, int iterations) : dropout_(dropout), iterations_(iterations) {}

  const char* name() const override { return "dropout"; }
  Period period() const override { return {.from = 1, .until = iterations_}; }
  std::string effect() const override {
    return fmt::format(
        "hides a random share of the splats, growing to {:g} / training views (at "
        "most {:g})",
        dropout_, kMaxHidden);
  }
  void before_render(Training& t) override {
    const double share =
        dropout_share(dropout_, t.data.train.size(), t.state.iteration, iterations_);
    t.true_opacities = hide_splats(t.state.parameters, share, t.state.random);
  }
  void after_backward(Training& t) override {
    restore_splats(t.state.parameters, t.true_opacities, t.rasterizer.gradient().row(row::opacity));
    t.true_opacities.clear();
  }

 private:
  double dropout_;
  int iterations_;
};

}  // namespace

OptionFields DropoutOptions::fields(const TrainOptions&) {
  return {real("dropout",
               "share of the splats that an iteration hides at the end, x training views (0: off)",
               dropout, 0, 1000)};
}

double dropout_share(double dropout, std::size_t views, int iteration, int iterations) {
  const double most =
      std::min(dropout / static_cast<double>(std::max<std::size_t>(views, 1)), kMaxHidden);
  return most * iteration / std::max(iterations, 1);
}

std::vector<float> hide_splats(PlanarFloats& parameters, double share, Random& random) {
  if (share <= 0) return {};
  float* logits = parameters.row(row::opacity);
  std::vector<float> true_opacities(logits, logits + parameters.size());
  const auto scale = static_cast<float>(1 / (1 - share));
  for (std::size_t i = 0; i < parameters.size(); ++i)
    logits[i] = uniform(random) < share ? kHidden : magnified(logits[i], scale);
  return true_opacities;
}

void restore_splats(PlanarFloats& parameters, const std::vector<float>& true_opacities,
                    float* opacity_gradient) {
  float* logits = parameters.row(row::opacity);
  for (std::size_t i = 0; i < true_opacities.size(); ++i) {
    if (logits[i] == true_opacities[i]) continue;
    // With o′ = s·o: do′/dl = s·o·(1 − o) = o′·(1 − o), where o′·(1 − o′) was taken. Where o′ is
    // limited it does not change; the slope just before the limit lets opacities come back.
    opacity_gradient[i] *= (1 - sigmoid(true_opacities[i])) / (1 - sigmoid(logits[i]));
    logits[i] = true_opacities[i];
  }
}

std::unique_ptr<Phase> make_dropout(TrainOptions& options) {
  const double dropout = options.get<DropoutOptions>().dropout;
  if (dropout <= 0) return nullptr;
  return std::make_unique<Dropout>(dropout, options.iterations);
}

}  // namespace fluxgs
