#include "trainer/train/run_estimate.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/gltf.h"
#include "trainer/compress/compact_search.h"
#include "trainer/core/clock.h"
#include "trainer/densify/densification.h"
#include "trainer/densify/density_control.h"
#include "trainer/raster/rasterizer.h"
#include "trainer/train/memory_budget.h"

namespace fluxgs {
namespace {

/// Seconds for which a rate remembers: so long, and a share of what has passed.
constexpr double kMemory = 20, kMemoryShare = 0.2;
/// An iteration that takes so many seconds, and so many times what is expected, was stopped
/// (Ctrl-Z): it tells nothing of the others.
constexpr double kStoppedSeconds = 10, kStoppedFactor = 20;
constexpr double kSettled = 3;            // seconds before files are measured
constexpr double kFilesMeasured = 2000;   // splats from which a file says what larger ones take
constexpr double kFileSeconds = 0.25e-6;  // of a value of a splat, before it was measured
/// Growth of the time of blending with pixels, before it was measured, and with splats.
constexpr double kBlendPixels = 0.8, kBlendSplats = 0.25;
constexpr std::size_t kBlendViews = 3;  // to measure it with
/// Time of projecting a splat, and of its gradient, but for colour: in SH coefficients.
constexpr double kGeometry = 11;
constexpr int kSegments = 200;               // of the iterations between two items
constexpr std::ptrdiff_t kGrowthEvents = 3;  // events whose growth is remembered
constexpr std::size_t kGrowthSeen = 2;       // events from which it counts alone
/// Usual number of splats, beyond which no growth is expected; in a run that has more all the same
/// it fades with each event. The longer splats are added, the more there are; eight captures had
/// 0.4 to 2.0 times as many in 7,000 and 30,000 iterations. Where each densification adds a share
/// only, the pixels of all images count, until gradients are known: 0.7 to 1.7 times as many in
/// 7,000 iterations, and 4.4 times of a capture of twelve images.
constexpr double kUsualSplats = 55e3, kUsualUntil = 3500, kUsualPower = 0.7;
constexpr double kLimitedSplats = 45e3, kLimitedPixels = 6e6, kLimitedPower = 0.3;
constexpr double kFade = 0.87;
/// By gradients: splats are added until g, the 85th percentile of the splats' mean gradients over
/// the threshold, has fallen to kLastGradient, so that their number grows by about
/// (g / kLastGradient)^kGradientPower; then larger images bring more. Fitted to fox and chesscat in
/// 30,000 iterations. Over fewer iterations between densifications the gradients are not those of
/// enough views.
constexpr double kGradientQuantile = 0.85, kLastGradient = 0.78, kGradientPower = 1.1;
constexpr double kImagePower = 0.38;  // of the pixels of full images over those of now
constexpr int kGradientInterval = 200;
/// Splat-tile pairs of a visible splat: more splats are smaller ones, and cover more tiles of
/// larger images. Powers of the number of splats and of pixels; iterations whose mean counts.
constexpr double kPairsOfSplats = -0.7, kPairsOfPixels = 0.5, kPairsMemory = 30;
/// Share of the bound that training_memory() is: not all of it is needed at once.
constexpr double kMemoryUsed = 0.8;

bool is_render_stage(const std::string& stage) {
  return stage == "project" || stage == "sort" || stage == "forward";
}

double pixels_of(const Camera& camera) { return static_cast<double>(camera.width) * camera.height; }

double mean_pixels(const std::vector<View>& views) {
  double sum = 0;
  for (const View& view : views) sum += pixels_of(view.camera);
  return sum / static_cast<double>(std::max<std::size_t>(views.size(), 1));
}

/// True if each densification adds a share of the splats at most, where views see errors.
bool adds_shares(const DensificationOptions& densification) {
  return densification.strategy == Densify::multiview && densification.growth > 0;
}

/// Number of splats that scenes have usually.
double usual_splats(const Trainer& trainer, double pixels) {
  const auto& densification = trainer.options.get<DensificationOptions>();
  if (!adds_shares(densification))
    return kUsualSplats * std::pow(densification.until / kUsualUntil, kUsualPower);
  const double all_pixels = pixels * static_cast<double>(trainer.data.train.size());
  return kLimitedSplats * std::pow(all_pixels / kLimitedPixels, kLimitedPower);
}

/// The same as the gradients say, just before a densification; nothing without a threshold. Images
/// will have `larger` times as many pixels.
std::optional<double> splats_by_gradients(const Trainer& trainer, double larger) {
  const auto& densification = trainer.options.get<DensificationOptions>();
  const TrainState& state = trainer.state;
  const std::size_t size = state.parameters.size();
  if (!adds_shares(densification) || densification.gradient <= 0 ||
      densification.interval < kGradientInterval || size == 0 || state.statistics.size() != size)
    return {};
  std::vector<float> means(size);
  for (std::size_t i = 0; i < size; ++i) means[i] = mean_gradient(state, i);
  const auto at = means.begin() +
                  static_cast<std::ptrdiff_t>(kGradientQuantile * static_cast<double>(size - 1));
  std::ranges::nth_element(means, at);
  const double gradient = static_cast<double>(*at) / densification.gradient;
  return static_cast<double>(size) *
         std::pow(std::max(gradient / kLastGradient, 1.0), kGradientPower) *
         std::pow(larger, kImagePower);
}

double pixel_share(const Schedule& schedule, int iteration) {
  double share = 1;
  for (const auto& phase : schedule.phases) share *= phase->pixel_share(iteration);
  return share;
}

/// Values of the splats that training has changed.
double values_of(double splats, int sh_degree) { return splats * row::count(sh_degree); }

/// Seconds of writing and reading a compact file, for each value; nothing of a scene too small.
std::optional<double> measured_file_seconds(const SplatCloud& cloud, int sh_degree) {
  if (static_cast<double>(cloud.size()) < kFilesMeasured) return {};
  const double start = wall_seconds();
  const auto file =
      encode_compact_glb(cloud, {.steps = default_quantization_steps(cloud)}, kCompactFileName);
  if (!file || !read_glb(*file, kCompactFileName)) return {};
  return (wall_seconds() - start) / values_of(static_cast<double>(cloud.size()), sh_degree);
}

}  // namespace

double RunEstimate::Learned::factor() const {
  return predicted > 0 ? std::clamp(actual / predicted, 0.1, 10.0) : 1;
}

/// The mean of the last ones; what is expected counts until there are two.
double RunEstimate::Learned::growth_or(double expected) const {
  const auto count = std::min(kGrowthEvents, static_cast<std::ptrdiff_t>(growth.size()));
  const double sum = std::accumulate(growth.end() - count, growth.end(), 0.0);
  return growth.size() >= kGrowthSeen ? sum / static_cast<double>(count)
                                      : (sum + expected) / static_cast<double>(count + 1);
}

RunEstimate::RunEstimate(const Trainer& trainer, const LaterWork& later)
    : trainer_(trainer),
      later_(later),
      pixels_(mean_pixels(trainer.data.train)),
      splats_before_(static_cast<double>(trainer.state.parameters.size())) {
  const std::size_t views = trainer.data.train.size();
  const double measured =
      2.0 * static_cast<double>(std::min(views, kEventViews) +
                                std::min(trainer.data.test.size(), kEventViews));
  for (int i = trainer.state.iteration + 1; i <= trainer.options.iterations; ++i)
    for (const auto& phase : trainer.schedule().phases) {
      PhaseWork work = phase->work(i, views);
      if (phase->reports(i)) work.renders += measured;
      if (work.renders > 0 || work.files > 0) items_.push_back({i, phase.get(), work});
    }
}

void RunEstimate::add(double seconds) {
  const double splats = static_cast<double>(trainer_.state.parameters.size());
  const int iteration = trainer_.state.iteration;
  double predicted = 0;
  int phases = 0;
  const Phase* phase = nullptr;
  for (; next_ < items_.size() && items_[next_].iteration <= iteration; ++next_) {
    phase = items_[next_].phase;
    ++phases;
    predicted += work_seconds(items_[next_], splats_before_) / learned_[phase].factor();
  }
  if (phase == nullptr && was_stopped(seconds)) {
    skip_stages();
    seconds = 0;
  } else if (phase == nullptr) {
    learn_stages(seconds,
                 {pixels_of(trainer_.view->camera), splats_before_, trainer_.render.sh_degree});
  } else {
    Learned& learned = learned_[phase];
    learned.actual += std::max(seconds - plain_seconds(iteration, splats_before_), 0.0);
    learned.predicted += predicted;
    if (phases == 1 && splats > 0 && splats_before_ > 0)
      learned.growth.push_back(std::log(splats / splats_before_));
    skip_stages();
  }
  elapsed_ += seconds;
  splats_before_ = splats;
  if (const double pairs = pairs_per_splat(trainer_.rasterizer.counts()); pairs > 0)
    pairs_ = pairs_ == 0 ? pairs : pairs_ + (pairs - pairs_) / kPairsMemory;
  if (next_ < items_.size() && items_[next_].iteration == iteration + 1 &&
      items_[next_].work.growth > 0)
    by_gradients_ = splats_by_gradients(trainer_, growth_of_images());
  if (file_seconds_ == 0 && elapsed_ > kSettled)
    file_seconds_ = measured_file_seconds(trainer_.cloud(), trainer_.render.sh_degree).value_or(0);
  if (!blend_power_ && elapsed_ > kSettled) blend_power_ = measured_blend_power();
}

/// Units of work of a stage of the profiler. All but the loss and the blending are for splats.
double RunEstimate::units_of(const std::string& stage, const Load& load) const {
  const int coefficients = (load.sh_degree + 1) * (load.sh_degree + 1);
  if (stage == "loss") return load.pixels;
  if (stage == "forward" || stage == "backward")
    return std::pow(load.pixels, blend_power_.value_or(kBlendPixels)) *
           std::pow(std::max(load.splats, 1.0), kBlendSplats);
  if (stage == "project" || stage == "gradient") return load.splats * (kGeometry + coefficients);
  if (stage == "adam") return values_of(load.splats, load.sh_degree);
  return load.splats;
}

/// Blends some views at the size of now and at the full size: where splats cover few pixels, the
/// time is theirs more than that of the pixels.
double RunEstimate::measured_blend_power() {
  const std::vector<View>& now = *trainer_.views;
  const std::vector<View>& full = trainer_.data.train;
  if (&now == &full) return kBlendPixels;
  const auto blend = [&](const Camera& camera) {
    Profiler profiler;
    const auto rasterizer = make_cpu_rasterizer(trainer_.threads, profiler);
    rasterizer->forward(trainer_.state.parameters, camera, trainer_.render_options());
    return profiler["forward"];
  };
  double pixels = 0, full_pixels = 0, seconds = 0, full_seconds = 0;
  for (std::size_t i = 0; i < kBlendViews; ++i) {
    const std::size_t at = i * full.size() / kBlendViews;
    pixels += pixels_of(now[at].camera), full_pixels += pixels_of(full[at].camera);
    seconds += blend(now[at].camera), full_seconds += blend(full[at].camera);
  }
  if (seconds <= 0 || full_pixels <= pixels) return kBlendPixels;
  const double power =
      std::clamp(std::log(full_seconds / seconds) / std::log(full_pixels / pixels), 0.0, 1.0);
  // The units so far are of the other power
  for (const char* stage : {"forward", "backward"})
    rates_[stage].units *= std::pow(pixels / kBlendViews, power - kBlendPixels);
  return power;
}

bool RunEstimate::was_stopped(double seconds) const {
  if (rates_.empty() || seconds < kStoppedSeconds) return false;
  return seconds > kStoppedFactor * plain_seconds(trainer_.state.iteration, splats_before_);
}

void RunEstimate::skip_stages() {
  for (const auto& [name, total] : trainer_.profiler.entries()) stages_before_[name] = total;
}

int RunEstimate::sh_degree(int iteration) const {
  int degree = sh_degree_of(trainer_.state.parameters);
  for (const auto& phase : trainer_.schedule().phases) degree = phase->sh_degree(iteration, degree);
  return degree;
}

void RunEstimate::learn_stages(double seconds, const Load& load) {
  const double keep = std::exp(-seconds / (kMemory + kMemoryShare * elapsed_));
  double known = 0;
  const auto learn = [&](const std::string& stage, double spent) {
    Rate& rate = rates_[stage];
    rate.seconds = keep * rate.seconds + spent;
    rate.units = keep * rate.units + units_of(stage, load);
  };
  for (const auto& [name, total] : trainer_.profiler.entries()) {
    double& before = stages_before_[name];
    const double spent = total - before;
    before = total;
    learn(name, spent);
    known += spent;
  }
  learn("", std::max(seconds - known, 0.0));
}

double RunEstimate::plain_seconds(int iteration, double splats) const {
  const Load load{pixels_ * pixel_share(trainer_.schedule(), iteration), splats,
                  sh_degree(iteration)};
  double sum = 0;
  for (const auto& [stage, rate] : rates_) sum += rate.value() * units_of(stage, load);
  return sum;
}

double RunEstimate::render_seconds(int iteration, double splats) const {
  const Load load{pixels_, splats, sh_degree(iteration)};
  double sum = 0;
  for (const auto& [stage, rate] : rates_)
    if (is_render_stage(stage)) sum += rate.value() * units_of(stage, load);
  return sum;
}

double RunEstimate::work_seconds(const Item& item, double splats) const {
  const auto learned = learned_.find(item.phase);
  const double file = file_seconds_ > 0 ? file_seconds_ : kFileSeconds;
  const double seconds = item.work.renders * render_seconds(item.iteration, splats) +
                         item.work.files * file * values_of(splats, sh_degree(item.iteration));
  return seconds * (learned == learned_.end() ? 1 : learned->second.factor());
}

/// `limited`: there are as many splats as scenes have usually, and only growth that was seen
/// counts.
double RunEstimate::growth_of(const Item& item, bool limited) const {
  const auto found = learned_.find(item.phase);
  if (found == learned_.end()) return limited ? std::min(item.work.growth, 0.0) : item.work.growth;
  const Learned& learned = found->second;
  const bool seen = learned.growth.size() >= kGrowthSeen;
  const double growth = learned.growth_or(item.work.growth);
  return limited && !seen ? std::min(growth, 0.0) : growth;
}

RunEstimate::Forecast RunEstimate::forecast() const {
  const int end = trainer_.options.iterations;
  int at = trainer_.state.iteration;
  double splats = static_cast<double>(trainer_.state.parameters.size());
  Forecast result{.splats = splats};
  const double usual = by_gradients_.value_or(usual_splats(trainer_, pixels_));
  double beyond = splats < usual ? 0 : 1;  // share of the growth that is left beyond that number
  const double measuring = later_.measuring_renders / std::max(end, 1);
  const auto iterate = [&](int until) {
    const int step = std::max(1, (until - at) / kSegments);
    while (at < until) {
      const int count = std::min(step, until - at);
      result.seconds += count * (plain_seconds(at + count / 2 + 1, splats) +
                                 measuring * render_seconds(at, splats));
      at += count;
    }
  };
  for (std::size_t i = next_; i < items_.size(); ++i) {
    const Item& item = items_[i];
    iterate(item.iteration);
    result.seconds += work_seconds(item, splats);
    double growth = growth_of(item, splats >= usual);
    if (splats >= usual && growth > 0) growth *= beyond *= kFade;
    splats *= std::exp(growth);
    if (trainer_.options.max_splats > 0)
      splats = std::min(splats, static_cast<double>(trainer_.options.max_splats));
    result.splats = std::max(result.splats, splats);
  }
  iterate(end);
  result.seconds += work_seconds({end, nullptr, later_.storing}, splats);
  return result;
}

/// Pixels of a full image over those of an image of now.
double RunEstimate::growth_of_images() const { return pixels_ / mean_pixels(*trainer_.views); }

/// Splat-tile pairs of a visible splat in full images, once there are so many splats.
double RunEstimate::pairs_at(double splats) const {
  if (pairs_ == 0) return kDefaultPairs;
  return pairs_ * std::pow(splats / std::max(splats_before_, 1.0), kPairsOfSplats) *
         std::pow(growth_of_images(), kPairsOfPixels);
}

std::size_t RunEstimate::memory_of(double splats) const {
  const std::size_t bound =
      training_memory(trainer_.data, trainer_.options, static_cast<std::size_t>(splats),
                      std::max(pairs_at(splats), kDefaultPairs));
  return static_cast<std::size_t>(kMemoryUsed * static_cast<double>(bound));
}

}  // namespace fluxgs
