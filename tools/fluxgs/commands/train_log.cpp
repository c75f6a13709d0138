#include "tools/fluxgs/commands/train_log.h"

#include <algorithm>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <nlohmann/json.hpp>

#include "trainer/core/clock.h"

namespace fluxgs::cli {

TrainLog::TrainLog(int iterations)
    : stretch_(std::max(1, iterations / 200)), start_(wall_seconds()) {}

namespace {

using nlohmann::json;

/// "PHASE at 9000: 24420 to 22668 splats, 29.54 to 29.45 dB on training views, …"
std::string line_of(const PhaseReport& r) {
  std::string line = fmt::format("{} at {}: ", r.name, r.iteration);
  if (r.splats.before != r.splats.after)
    line += fmt::format("{} to {} splats, ", r.splats.before, r.splats.after);
  line +=
      fmt::format("{:.2f} to {:.2f} dB on training views", r.train_psnr.before, r.train_psnr.after);
  if (r.test_psnr)
    line += fmt::format(", {:.2f} to {:.2f} on test", r.test_psnr->before, r.test_psnr->after);
  if (r.bytes) line += fmt::format(", {} to {} bytes", r.bytes->before, r.bytes->after);
  return r.summary.empty() ? line : line + "; " + r.summary;
}

template <class T>
json pair_of(const Change<T>& change) {
  return {change.before, change.after};
}

json json_of(const PhaseReport& r) {
  json row = {{"phase", r.name},
              {"iteration", r.iteration},
              {"train_psnr", pair_of(r.train_psnr)},
              {"test_psnr", r.test_psnr ? pair_of(*r.test_psnr) : json()},
              {"splats", pair_of(r.splats)},
              {"bytes", r.bytes ? pair_of(*r.bytes) : json()}};
  row.update(r.details);
  return row;
}

}  // namespace

void TrainLog::add_phase(const PhaseReport& report) {
  phases_.push_back(json_of(report));
  if (report.test_psnr)
    for (const double psnr : {report.test_psnr->before, report.test_psnr->after})
      psnr_.push_back({report.iteration, psnr});
  spdlog::info("{}", line_of(report));
}

void TrainLog::add(int iteration, const IterationReport& report, std::size_t splats) {
  for (const PhaseReport& phase : report.phases) add_phase(phase);
  loss_ += report.loss;
  l1_ += report.sums.l1;
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

nlohmann::json TrainLog::to_json() const {
  return {
      {"phases", phases_}, {"psnr", psnr_},     {"iteration", iteration_},        {"loss", losses_},
      {"l1", l1s_},        {"splats", splats_}, {"iterations_per_second", rates_}};
}

namespace {

json joined(const json& before, const json& after) {
  if (before.is_null()) return after;
  json curves = before;
  for (const auto& [key, value] : after.items()) {
    json& all = curves[key];
    if (all.is_array() && value.is_array())
      all.insert(all.end(), value.begin(), value.end());
    else if (!value.is_null())
      all = value;
  }
  return curves;
}

}  // namespace

std::string text_of(const TrainHistory& history) {
  return json{{"seconds", history.seconds},
              {"cpu_seconds", history.cpu_seconds},
              {"rejected_gradients", history.rejected_gradients},
              {"stages", history.stages},
              {"stages_cpu", history.stages_cpu},
              {"curves", history.curves}}
      .dump();
}

TrainHistory history_of(const std::string& text) {
  try {
    const json all = json::parse(text);
    TrainHistory history;
    all.at("seconds").get_to(history.seconds);
    all.at("cpu_seconds").get_to(history.cpu_seconds);
    all.at("rejected_gradients").get_to(history.rejected_gradients);
    all.at("stages").get_to(history.stages);
    history.stages_cpu = all.value("stages_cpu", history.stages_cpu);  // newer than the others
    history.curves = all.at("curves");
    const bool known = history.curves.is_object() || history.curves.is_null();
    return known ? history : TrainHistory{};
  } catch (const json::exception&) {
    return {};
  }
}

TrainHistory joined(const TrainHistory& before, const TrainHistory& after) {
  TrainHistory all = after;
  all.seconds += before.seconds;
  all.cpu_seconds += before.cpu_seconds;
  all.rejected_gradients += before.rejected_gradients;
  for (const auto& [name, seconds] : before.stages) all.stages[name] += seconds;
  for (const auto& [name, seconds] : before.stages_cpu) all.stages_cpu[name] += seconds;
  all.curves = joined(before.curves, after.curves);
  return all;
}

}  // namespace fluxgs::cli
