#include "trainer/train/sh_curriculum.h"

#include <algorithm>

#include <fmt/format.h>

namespace fluxgs {
namespace {

class ShCurriculum final : public Phase {
 public:
  ShCurriculum(int interval, int degree, int reduced_at)
      : interval_(interval), degree_(degree), reduced_at_(reduced_at) {}

  const char* name() const override { return "SH curriculum"; }
  Period period() const override {
    const int last = interval_ * degree_;
    return {.from = 1, .until = reduced_at_ > 0 ? std::min(last, reduced_at_) : last};
  }
  std::string effect() const override {
    return fmt::format("raises the SH degree by one every {} iterations, to {}", interval_,
                       degree_);
  }
  int sh_degree(int iteration, int degree) const override {
    const int done = iteration - 1;
    if (reduced_at_ > 0 && done > reduced_at_) return degree;
    return std::min(degree, done / interval_);
  }
  void configure(RenderOptions& render, const TrainState& state) const override {
    render.sh_degree = sh_degree(state.iteration + 1, render.sh_degree);
  }

 private:
  int interval_, degree_, reduced_at_;
};

}  // namespace

OptionFields ShCurriculumOptions::fields(const TrainOptions& all) {
  return {whole("sh-degree-interval",
                "iterations until the SH degree in use grows by one (0: an eighth of the "
                "iterations, at most 1000 and a quarter of those before the SH reduction)",
                interval, 0, kUnlimited)
              .only_if(all.sh_degree > 0, "a --sh-degree of more than 0")};
}

std::unique_ptr<Phase> make_sh_curriculum(TrainOptions& options, int degree, int reduced_at) {
  const int n = options.iterations;
  auto& own = options.get<ShCurriculumOptions>();
  resolve(own.interval, std::min({n / 8 + 1, 1000, reduced_at > 0 ? reduced_at / 4 : n}));
  if (degree == 0) return nullptr;
  return std::make_unique<ShCurriculum>(own.interval, degree, reduced_at);
}

}  // namespace fluxgs
