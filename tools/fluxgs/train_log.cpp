#include "tools/fluxgs/train_log.h"

#include <algorithm>

#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "trainer/core/clock.h"

namespace fluxgs::cli {

TrainLog::TrainLog(int iterations)
    : stretch_(std::max(1, iterations / 200)), start_(wall_seconds()) {}

void TrainLog::add(int iteration, const StepReport& step, std::size_t splats) {
  if (step.switched) add_switch(iteration, *step.switched);
  if (step.pruned_late) add_late_prune(iteration, *step.pruned_late);
  if (step.rounded) add_rounding(iteration, *step.rounded);
  loss_ += step.loss;
  l1_ += step.sums.l1;
  ++count_;
  if (iteration % stretch_ != 0) return;
  iteration_.push_back(iteration);
  losses_.push_back(loss_ / count_);
  l1s_.push_back(l1_ / count_);
  splats_.push_back(splats);
  const double now = wall_seconds();
  rates_.push_back(count_ / std::max(now - start_, 1e-9));
  start_ = now;
  loss_ = l1_ = count_ = 0;
}

void TrainLog::measure_psnr(int iteration, const Trainer& trainer, const std::vector<View>& views) {
  if (views.empty()) return;
  const double start = wall_seconds(), cpu_start = cpu_seconds();
  psnr_.push_back({iteration, trainer.mean_psnr(views)});
  measuring_ += wall_seconds() - start;
  measuring_cpu_ += cpu_seconds() - cpu_start;
}

void TrainLog::add_switch(int iteration, const SwitchReport& report) {
  const auto& test = report.test_psnr;
  switch_ = {{"iteration", iteration},
             {"train_psnr", {report.train_psnr_before, report.train_psnr_after}},
             {"test_psnr", test ? nlohmann::json(*test) : nlohmann::json()},
             {"bytes", {report.bytes_before, report.bytes_after}},
             {"mse_if_truncated", report.reduction.dropped},
             {"mse_if_fitted", report.reduction.unexplained},
             {"sphere_prior", report.reduction.sphere_prior},
             {"splats_of_degree", report.reduction.degrees}};
  std::string on_test;
  if (test) {
    for (const double psnr : *test) psnr_.push_back({iteration, psnr});
    on_test = fmt::format(", {:.2f} to {:.2f} on test", test->front(), test->back());
  }
  spdlog::info(
      "SH coefficients reduced: {:.2f} to {:.2f} dB on training views{}; a file of {} bytes to {}",
      report.train_psnr_before, report.train_psnr_after, on_test, report.bytes_before,
      report.bytes_after);
  const auto& degrees = report.reduction.degrees;
  if (degrees[0] + degrees[1] + degrees[2] > 0)
    spdlog::info("splats of degree 0 to 3: {}", fmt::join(degrees, ", "));
}

void TrainLog::add_late_prune(int iteration, const LatePruneReport& report) {
  late_prunes_.push_back({{"iteration", iteration},
                          {"splats", {report.splats_before, report.splats_after}},
                          {"train_psnr", {report.train_psnr_before, report.train_psnr_after}}});
  spdlog::info("late pruning: {} to {} splats, {:.2f} to {:.2f} dB on training views",
               report.splats_before, report.splats_after, report.train_psnr_before,
               report.train_psnr_after);
}

void TrainLog::add_rounding(int iteration, const RoundingReport& report) {
  if (report.error)
    return spdlog::warn("warning: nothing is rounded from step {} on: {}", iteration,
                        report.error->message());
  rounding_ = {{"iteration", iteration},
               {"bytes", report.bytes},
               {"train_psnr", {report.train_psnr_before, report.train_psnr_after}}};
  spdlog::info("rounded as in a file of {} bytes: {:.2f} to {:.2f} dB on training views",
               report.bytes, report.train_psnr_before, report.train_psnr_after);
}

nlohmann::json TrainLog::to_json() const {
  return {{"switch", switch_}, {"rounding", rounding_},   {"late_prunes", late_prunes_},
          {"psnr", psnr_},     {"iteration", iteration_}, {"loss", losses_},
          {"l1", l1s_},        {"splats", splats_},       {"iterations_per_second", rates_}};
}

}  // namespace fluxgs::cli
