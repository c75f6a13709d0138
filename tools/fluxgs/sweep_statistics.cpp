#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "tools/fluxgs/sweep_table.h"

namespace fluxgs::cli {
namespace {

std::optional<double> value_of(const RunOutcome& outcome, const char* key) {
  const auto found = outcome.values.find(key);
  if (outcome.state != RunState::finished || found == outcome.values.end()) return std::nullopt;
  return found->second;
}

}  // namespace

Statistic statistic_of(std::span<const double> values) {
  Statistic s{.count = static_cast<int>(values.size())};
  if (values.empty()) return s;
  const double n = static_cast<double>(values.size());
  s.mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  if (values.size() < 2) return s;
  double squares = 0;
  for (const double v : values) squares += (v - s.mean) * (v - s.mean);
  s.deviation = std::sqrt(squares / (n - 1));
  return s;
}

std::span<const SweepMetric> sweep_metrics() {
  static constexpr SweepMetric kMetrics[] = {{"psnr", "PSNR (dB)", 1, 2},
                                             {"ssim", "SSIM", 1, 4},
                                             {"switch_psnr", "at the switch (dB)", 1, 2, false},
                                             {"stored_psnr", "compact: PSNR (dB)", 1, 2},
                                             {"stored_ssim", "compact: SSIM", 1, 4},
                                             {"stored_flip", "compact: FLIP", 1, 4},
                                             {"splats", "splats", 1, 0},
                                             {"stored_bytes", "compact .glb (MB)", 1e-6, 3},
                                             {"ply_bytes", ".ply (MB)", 1e-6, 2},
                                             {"seconds", "time (min)", 1.0 / 60, 2},
                                             {"cpu_seconds", "CPU (min)", 1.0 / 60, 2},
                                             {"frame_ms", "frame (ms)", 1, 1}};
  return kMetrics;
}

int SweepTable::count(RunState state) const {
  return static_cast<int>(std::ranges::count(outcomes, state, &RunOutcome::state));
}

Statistic over_seeds(const SweepTable& table, std::size_t scene, std::size_t row, const char* key) {
  std::vector<double> values;
  for (std::size_t seed = 0; seed < table.seeds.size(); ++seed)
    if (const auto v = value_of(table.at(scene, row, seed), key)) values.push_back(*v);
  return statistic_of(values);
}

Statistic over_scenes(const SweepTable& table, std::size_t row, const char* key) {
  std::vector<double> means;
  for (std::size_t seed = 0; seed < table.seeds.size(); ++seed) {
    double sum = 0;
    std::size_t found = 0;
    for (std::size_t scene = 0; scene < table.scenes.size(); ++scene)
      if (const auto v = value_of(table.at(scene, row, seed), key)) sum += *v, ++found;
    if (found == table.scenes.size()) means.push_back(sum / static_cast<double>(found));
  }
  return statistic_of(means);
}

}  // namespace fluxgs::cli
