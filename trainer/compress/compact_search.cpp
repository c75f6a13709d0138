#include "trainer/compress/compact_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "fluxgs/io/gltf.h"

namespace fluxgs {
namespace {

constexpr double kFinest = 0x1p-12, kCoarsest = 0x1p12;  // of the steps that the search begins with
constexpr int kBalances = 2, kMaxTrials = 24;
constexpr int kUsualTrials = 4;           // of one solve(), for the progress
constexpr double kStride = 1;             // at most, of the logarithm of the step scale
constexpr double kCloseEnough = 0.003;    // the same
constexpr float kExactly = 0x1p-8f;       // of a step, where an error is not to count
constexpr double kErrorTolerance = 0.01;  // 0.04 dB: other views differ by more
constexpr double kSizeTolerance = 1e-3;
constexpr double kSizeToleranceAtFirst = 0.01;
constexpr double kRoughTolerance = 0.1;

/// An attribute of the codec: its name in AttributeBits, its step, and its array. Rounding
/// SH coefficients changes the constant colours (codec/sh.h): the error of either is
/// measured while the other is stored `exactly`, and that of SH coefficients with both.
struct Part {
  const char* name;
  void (*scale_step)(QuantizationSteps&, double);
  void (*take)(SplatCloud& to, const SplatCloud& from);
  float QuantizationSteps::* exactly = nullptr;
};

constexpr Part kParts[] = {
    {"position", [](QuantizationSteps& s, double f) { s.position *= f; },
     [](SplatCloud& to, const SplatCloud& from) { to.positions = from.positions; }},
    {"scale", [](QuantizationSteps& s, double f) { s.log_scale *= static_cast<float>(f); },
     [](SplatCloud& to, const SplatCloud& from) { to.log_scales = from.log_scales; }},
    {"rotation", [](QuantizationSteps& s, double f) { s.rotation *= static_cast<float>(f); },
     [](SplatCloud& to, const SplatCloud& from) { to.rotations = from.rotations; }},
    {"opacity", [](QuantizationSteps& s, double f) { s.opacity *= static_cast<float>(f); },
     [](SplatCloud& to, const SplatCloud& from) { to.opacity_logits = from.opacity_logits; }},
    {"sh_dc", [](QuantizationSteps& s, double f) { s.sh_dc *= static_cast<float>(f); },
     [](SplatCloud& to, const SplatCloud& from) { to.sh_dc = from.sh_dc; },
     &QuantizationSteps::sh_rest},
    {"sh_rest", [](QuantizationSteps& s, double f) { s.sh_rest *= static_cast<float>(f); },
     [](SplatCloud& to, const SplatCloud& from) {
       to.sh_degree = from.sh_degree;  // a file does without bands that no splat has
       to.sh_rest = from.sh_rest;
       to.sh_dc = from.sh_dc;
     },
     &QuantizationSteps::sh_dc},
    {"energy", [](QuantizationSteps& s, double f) { s.energy *= static_cast<float>(f); },
     [](SplatCloud& to, const SplatCloud& from) {
       to.sh_dc = from.sh_dc, to.sh_rest = from.sh_rest;
     }},
};
constexpr std::size_t kPartCount = std::size(kParts);

/// Finer steps say nothing that an image shows, and may be beyond the codec.
QuantizationSteps at_least(QuantizationSteps steps, double position) {
  constexpr float kFinestOfAll = 3e-6f;
  steps.position = std::max(steps.position, position);
  for (float* step : {&steps.log_scale, &steps.rotation, &steps.opacity, &steps.sh_dc,
                      &steps.sh_rest, &steps.energy})
    *step = std::max(*step, kFinestOfAll);
  return steps;
}

struct Stored {
  std::vector<std::byte> file;
  SceneFile scene;
};

Expected<Stored> store(const SplatCloud& cloud, const CompactOptions& options) {
  auto file = encode_compact_glb(cloud, options, kCompactFileName);
  if (!file) return std::unexpected(file.error());
  auto scene = read_glb(*file, kCompactFileName);
  if (!scene) return std::unexpected(scene.error());
  return Stored{std::move(*file), std::move(*scene)};
}

}  // namespace

CompactSearch::CompactSearch(const SplatCloud& cloud, const SplatCloud& shown,
                             const SceneError& error, CompactOptions options,
                             ProgressReport progress)
    : cloud_(cloud),
      shown_(shown),
      error_(error),
      options_(std::move(options)),
      progress_(std::move(progress)),
      finest_position_(finest_position_step(cloud)) {}

Expected<CompactTrial> CompactSearch::trial(const QuantizationSteps& steps) const {
  CompactTrial result{.options = options_, .file = {}, .attribute_bits = {}};
  result.options.steps = at_least(steps, finest_position_);
  auto stored = store(cloud_, result.options);
  if (!stored) return std::unexpected(stored.error());
  const auto mse = error_.mse(stored->scene.cloud);
  if (!mse) return std::unexpected(mse.error());
  result.file = std::move(stored->file);
  result.attribute_bits = std::move(stored->scene.attribute_bits);
  result.mse = *mse;
  return result;
}

/// With only attribute `part` quantized, of a scene that is `stored` with these steps; `exact` is
/// what is shown, as in that file.
Expected<double> CompactSearch::error_of(std::size_t part, const QuantizationSteps& steps,
                                         const SplatCloud& exact, const SplatCloud& stored) const {
  const Part& own = kParts[part];
  SplatCloud one = exact;
  if (own.exactly == nullptr) {
    own.take(one, stored);
    return error_.mse(one);
  }
  CompactOptions options = options_;
  options.steps = steps;
  options.steps.*own.exactly *= kExactly;
  options.steps = at_least(options.steps, finest_position_);
  const auto alone = store(cloud_, options);
  if (!alone) return std::unexpected(alone.error());
  own.take(one, alone->scene.cloud);
  return error_.mse(one);
}

Expected<QuantizationSteps> CompactSearch::balanced(const QuantizationSteps& steps) const {
  CompactOptions options = options_;
  options.steps = steps;
  const auto stored = store(cloud_, options);
  if (!stored) return std::unexpected(stored.error());
  const SplatCloud exact = in_order(shown_, compact_order(cloud_, options));
  options.steps = at_least(scaled(steps, std::numbers::sqrt2 / 2), finest_position_);
  const auto finer = store(cloud_, options);
  if (!finer) return std::unexpected(finer.error());

  // With mse ∝ step² and so many bits for each halving of the step, one bit more of an attribute
  // buys 2·ln 2·mse/bits.
  std::array<double, kPartCount> bits{}, gain{};
  double sum = 0, mean = 0;
  for (std::size_t p = 0; p < kPartCount; ++p) {
    const Part& part = kParts[p];
    if (!stored->scene.attribute_bits.contains(part.name)) continue;
    bits[p] = 2 * (finer->scene.attribute_bits.at(part.name) -
                   stored->scene.attribute_bits.at(part.name));
    const auto mse = error_of(p, steps, exact, stored->scene.cloud);
    if (!mse) return std::unexpected(mse.error());
    if (!(bits[p] > 1e-3 && *mse > 0)) continue;
    gain[p] = *mse / bits[p];
    sum += bits[p];
    mean += bits[p] * std::log(gain[p]);
  }
  QuantizationSteps result = steps;
  for (std::size_t p = 0; p < kPartCount; ++p)
    if (gain[p] > 0)
      kParts[p].scale_step(result,
                           std::clamp(std::exp(0.5 * (mean / sum - std::log(gain[p]))), 0.5, 2.0));
  return result;
}

/// The cheapest trial that fits at any scale of these steps. Where nothing fits, nothing;
/// `last` is then the finest.
Expected<std::optional<CompactTrial>> CompactSearch::solve(const QuantizationSteps& steps,
                                                           const Goal& goal, CompactTrial& last,
                                                           const ProgressReport& progress) const {
  // Of the logarithm of the step scale or, where coarser steps are what fits, of its negative
  const double sign = goal.coarser_fits ? -1 : 1;
  const double ends[] = {sign * std::log(kFinest), sign * std::log(kCoarsest)};
  double low = std::min(ends[0], ends[1]), high = std::max(ends[0], ends[1]), at = 0;
  double low_excess = 0, high_excess = 0;
  bool has_low = false, has_high = false;
  std::optional<CompactTrial> best;
  for (int i = 0; i < kMaxTrials && high - low > kCloseEnough; ++i) {
    auto tried = trial(scaled(steps, std::exp(sign * at)));
    if (!tried) return std::unexpected(tried.error());
    if (progress) progress(static_cast<std::size_t>(std::min(i + 1, kUsualTrials)), kUsualTrials);
    const double excess = goal.excess(*tried);
    last = *tried;
    if (excess > 0) {
      high = at, high_excess = excess, has_high = true;
    } else {
      low = at, low_excess = excess, has_low = true;
      if (!best || goal.cost(*tried) < goal.cost(*best)) best = std::move(*tried);
      if (excess > -goal.tolerance || best->mse <= goal.enough) break;
    }
    const double aim = -goal.tolerance / 2;
    if (has_low && has_high) {
      // Along the straight line between the ends, now and then halving, so as not to get stuck
      const double part =
          i % 4 == 3 ? 0.5
                     : std::clamp((aim - low_excess) / (high_excess - low_excess), 0.02, 0.98);
      at = low + part * (high - low);
    } else {
      at = std::clamp(at + std::clamp((aim - excess) / goal.slope, -kStride, kStride), low, high);
    }
  }
  return best;
}

Expected<CompactTrial> CompactSearch::reach(const Goal& goal, CompactTrial& last) const {
  // A balance renders and stores about as often as so many trials
  const ProgressParts parts(progress_, {kUsualTrials, 8, kUsualTrials, 8, kUsualTrials});
  Goal rough = goal;  // for steps that are balanced next
  rough.tolerance = kRoughTolerance;
  QuantizationSteps steps = options_.steps;
  std::optional<CompactTrial> best;
  for (int round = 0; round <= goal.balances; ++round) {
    const auto part = static_cast<std::size_t>(2 * round);
    const bool is_last = round == goal.balances;
    auto found = solve(steps, is_last ? goal : rough, last, parts.part(part));
    if (!found) return std::unexpected(found.error());
    if (!*found) break;
    const QuantizationSteps from = (*found)->options.steps;
    if (!best || goal.cost(**found) < goal.cost(*best)) best = std::move(**found);
    if (is_last || best->mse <= goal.enough) break;
    if (progress_) parts.part(part)(1, 1);
    const auto balance = balanced(from);
    if (!balance) return std::unexpected(balance.error());
    if (progress_) parts.part(part + 1)(1, 1);
    steps = *balance;
  }
  if (progress_) parts.part(2 * kBalances)(1, 1);
  if (!best) return fail("", "", "");  // the caller says what was missed
  return std::move(*best);
}

Expected<CompactTrial> CompactSearch::within_loss(double decibels) const {
  const double most = mse_of_psnr(decibels);
  const Goal goal{
      .coarser_fits = false,
      .enough = 0,
      .balances = kBalances,
      .tolerance = kErrorTolerance,
      .slope = 2,  // mse ∝ step²
      .excess = [most](const CompactTrial& t) { return std::log(std::max(t.mse, 1e-30) / most); },
      .cost = [](const CompactTrial& t) { return static_cast<double>(t.file.size()); }};
  CompactTrial last;
  auto result = reach(goal, last);
  if (result || !result.error().what.empty()) return result;
  return fail("", "loss",
              fmt::format("the finest compact file is {:.2f} dB from the scene, expected {:g}",
                          last.psnr(), decibels));
}

Expected<CompactTrial> CompactSearch::within_bytes(std::size_t bytes, std::size_t beside) const {
  return search_bytes(bytes, beside, kBalances, kSizeTolerance);
}

Expected<CompactTrial> CompactSearch::first_within_bytes(std::size_t bytes,
                                                         std::size_t beside) const {
  return search_bytes(bytes, beside, 0, kSizeToleranceAtFirst);
}

Expected<CompactTrial> CompactSearch::search_bytes(std::size_t bytes, std::size_t beside,
                                                   int balances, double tolerance) const {
  const auto most = static_cast<double>(std::max(bytes, beside + 1) - beside);
  const Goal goal{.coarser_fits = true,
                  .enough = kInvisibleMse,
                  .balances = balances,
                  .tolerance = tolerance,
                  .slope = 0.4,  // log₂ of the step's inverse is a quarter of the bits of a value
                  .excess =
                      [most](const CompactTrial& t) {
                        return std::log(static_cast<double>(t.file.size()) / most);
                      },
                  .cost = [](const CompactTrial& t) { return t.mse; }};
  CompactTrial last;
  auto result = reach(goal, last);
  if (result || !result.error().what.empty()) return result;
  return fail("", "size",
              fmt::format("the coarsest file {}has {} bytes, expected {} at most",
                          options_.plain_attributes ? "with plain attributes " : "",
                          last.file.size() + beside, bytes));
}

}  // namespace fluxgs
