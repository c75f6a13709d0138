#include "trainer/densify/dropout.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "trainer/core/logistic.h"

namespace fluxgs {
namespace {

constexpr double kMaxHidden = 0.2;  // as the authors use
constexpr float kHidden = -30;      // a logit far below what is drawn

/// The logit of `scale` × the opacity of another, up to kOpaque; opaquer ones stay as they are.
float magnified(float opacity_logit, float scale) {
  const float opacity = sigmoid(opacity_logit), most = static_cast<float>(Dropout::kOpaque);
  if (opacity >= most) return opacity_logit;
  const float more = std::min(opacity * scale, most);
  return more > 0 ? logit(more) : opacity_logit;
}

}  // namespace

double dropout_share(const TrainOptions& options, std::size_t views, int iteration) {
  const double most =
      std::min(options.dropout / static_cast<double>(std::max<std::size_t>(views, 1)), kMaxHidden);
  return most * iteration / std::max(options.iterations, 1);
}

void Dropout::hide(PlanarFloats& parameters, double share, Random& random) {
  logits_.clear();
  if (share <= 0) return;
  float* logits = parameters.row(row::opacity);
  logits_.assign(logits, logits + parameters.size());
  const auto scale = static_cast<float>(1 / (1 - share));
  for (std::size_t i = 0; i < logits_.size(); ++i)
    logits[i] = uniform(random) < share ? kHidden : magnified(logits[i], scale);
}

void Dropout::exchange(PlanarFloats& parameters) {
  std::ranges::swap_ranges(logits_, std::span(parameters.row(row::opacity), logits_.size()));
}

void Dropout::restore(PlanarFloats& parameters, float* opacity_gradient) {
  float* logits = parameters.row(row::opacity);
  for (std::size_t i = 0; i < logits_.size(); ++i) {
    if (logits[i] == logits_[i]) continue;
    // With o′ = s·o: do′/dl = s·o·(1 − o) = o′·(1 − o), where o′·(1 − o′) was taken. Where o′ is
    // limited it does not change; the slope just before the limit lets opacities come back.
    opacity_gradient[i] *= (1 - sigmoid(logits_[i])) / (1 - sigmoid(logits[i]));
    logits[i] = logits_[i];
  }
  logits_.clear();
}

}  // namespace fluxgs
