#include "trainer/compress/quantization_aware.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <glm/gtc/quaternion.hpp>

#include "fluxgs/io/gltf.h"
#include "trainer/compress/compact_search.h"
#include "trainer/compress/compression.h"
#include "trainer/data/dataset.h"

namespace fluxgs {
namespace {

constexpr double kPsnrShare = 0.1;  // of the work, for the PSNR that a file may fall behind

/// to += sign·what.
void add(PlanarFloats& to, const PlanarFloats& what, float sign) {
  for (int r = 0; r < to.rows(); ++r)
    for (std::size_t i = 0; i < to.size(); ++i) to.row(r)[i] += sign * what.row(r)[i];
}

/// q·h of the unit ±1, ±i, ±j or ±k that h is nearest to.
glm::dquat times_nearest_unit(const glm::dquat& q, const glm::dquat& h) {
  const double parts[] = {h.w, h.x, h.y, h.z};
  const auto largest =
      std::ranges::max_element(parts, {}, [](double part) { return std::abs(part); });
  double unit[4] = {};
  unit[largest - parts] = std::copysign(1.0, *largest);
  return q * glm::dquat(unit[0], unit[1], unit[2], unit[3]);
}

void put_quaternion(PlanarFloats& rows, std::size_t i, const glm::dquat& q) {
  const double parts[] = {q.w, q.x, q.y, q.z};
  for (int c = 0; c < 4; ++c) rows.row(row::rotation + c)[i] = static_cast<float>(parts[c]);
}

/// After rotations q of a state became |q|⁻¹·q·h with a half turn h, their gradients become
/// |q|·g·h: moments of quaternions that came before follow them.
void follow_rotations(const PlanarFloats& before, const std::vector<glm::quat>& after,
                      AdamState& adam) {
  for (std::size_t i = 0; i < after.size(); ++i) {
    const glm::dquat q = rotation_of(before, i);
    const double length = glm::length(q);
    const glm::dquat h =
        length > 0 ? glm::conjugate(q) * glm::dquat(after[i]) : glm::dquat(1, 0, 0, 0);
    put_quaternion(adam.first, i, times_nearest_unit(rotation_of(adam.first, i), h) * length);
    const glm::dquat second =
        times_nearest_unit(rotation_of(adam.second, i), h) * (length * length);
    put_quaternion(
        adam.second, i,
        {std::abs(second.w), std::abs(second.x), std::abs(second.y), std::abs(second.z)});
  }
}

/// The lists of `costs` with the number of their entries for each splat, in the order in which
/// attached values hold them.
template <class Sensitivity, class Visit>
void visit_lists(Sensitivity& sensitivity, int sh_degree, const Visit& visit) {
  visit(sensitivity.weights, std::size_t{1});
  visit(sensitivity.sh_factors, sh_factor_size(sh_degree));
  visit(sensitivity.scale, kSymmetric3);
  visit(sensitivity.rotation, kSymmetric3);
}

SensitivityWeights attached_sensitivity(const TrainState& state) {
  SensitivityWeights sensitivity;
  const auto found = state.attached.find(kSensitivity);
  if (found == state.attached.end()) return sensitivity;
  const PlanarFloats& values = found->second.values;
  int row = 0;
  visit_lists(sensitivity, sh_degree_of(state.parameters), [&](auto& list, std::size_t each) {
    list.resize(values.size() * each);
    for (std::size_t k = 0; k < each; ++k, ++row)
      for (std::size_t i = 0; i < values.size(); ++i) list[i * each + k] = values.row(row)[i];
  });
  return sensitivity;
}

class QuantizationAware final : public Phase {
 public:
  QuantizationAware(const QuantizationAwareOptions& options, int asked, int iterations,
                    const ScreenFilter& filter)
      : options_(options), asked_(asked), iterations_(iterations), filter_(filter) {}

  const char* name() const override { return "quantization-aware training"; }
  Period period() const override { return {.from = options_.from, .until = iterations_}; }
  std::string effect() const override {
    return fmt::format("trains the values of the compact file, quantized every {} iterations",
                       options_.interval);
  }
  std::string warning() const override {
    if (asked_ == 0 || options_.from <= asked_) return {};
    return fmt::format(
        "quantization-aware training begins at iteration {} instead of {}, after "
        "densification and the SH reduction",
        options_.from, asked_);
  }
  bool reports(int iteration) const override { return iteration == options_.from; }
  PhaseWork work(int iteration, std::size_t views) const override {
    if (reports(iteration)) return compact_search_work(views, iterations_);
    return {.files = is_due(iteration) ? 1.0 : 0.0};
  }

  bool can_be_stopped() const override { return true; }
  std::optional<PhaseReport> after_step(Training& t) override {
    if (reports(t.state.iteration) && t.state.parameters.size() > 0) return start(t);
    if (!steps_) return {};
    if (!is_due(t.state.iteration)) return {};
    const auto file = quantize_parameters(t.state, *steps_, filter_);
    if (file) return {};
    return stop(t.state, file.error());
  }
  std::optional<Expected<std::vector<std::byte>>> compact_file(
      const TrainState& state) const override {
    if (!steps_) return {};
    TrainState copy = state;
    return quantize_parameters(copy, *steps_, filter_);
  }

  std::vector<double> save() const override {
    if (!steps_) return {};
    const QuantizationSteps& s = *steps_;
    return {s.position, s.log_scale, s.rotation, s.opacity, s.sh_dc, s.sh_rest, s.energy};
  }
  Expected<void> load(const std::vector<double>& values, const TrainState& state) override;

 private:
  /// True if values are quantized anew.
  bool is_due(int iteration) const {
    const int since = iteration - options_.from;
    return since > 0 && (since % options_.interval == 0 || iteration >= iterations_);
  }
  /// Searches for the step sizes and quantizes for the first time.
  PhaseReport start(Training& t) {
    const SplatCloud scene = t.cloud();
    const ProgressParts parts(t.control.progress, {kPsnrShare, 1 - kPsnrShare});
    const CompactGoal goal{cameras_of(t.data.train), t.options.render, asked_psnr(t, parts.part(0)),
                           t.options.iterations};
    auto found = compact_within(scene, scene, goal, {.steps = default_quantization_steps(scene)},
                                t.threads, {parts.part(1), t.control.stop});
    if (!found) return stop(t.state, found.error());
    steps_ = found->options.steps;
    attach_sensitivity(t.state, found->options.sensitivity);
    const auto file = quantize_parameters(t.state, *steps_, filter_);
    if (!file) return stop(t.state, file.error());
    PhaseReport report;
    report.details = {{"bytes", file->size()}};
    report.summary = fmt::format("quantized as in a file of {} bytes", file->size());
    return report;
  }
  /// PSNR that the file shall have, to renders of the scene.
  static double asked_psnr(Training& t, const ProgressReport& progress) {
    const WorkControl outer = t.control;
    t.control.progress = progress;
    const double psnr = t.mean_psnr(t.data.train);
    t.control = outer;
    return compressed_psnr(psnr, t.options.get<CompressionOptions>());
  }
  /// A lost file is no reason to lose the scene.
  PhaseReport stop(TrainState& state, const Error& error) {
    steps_.reset();
    state.attached.erase(kQuantizationOffsets);
    state.attached.erase(kSensitivity);
    PhaseReport report;
    report.error = error;
    return report;
  }

  QuantizationAwareOptions options_;
  int asked_, iterations_;
  ScreenFilter filter_;                     ///< of the scene
  std::optional<QuantizationSteps> steps_;  ///< once it has begun
};

Expected<void> QuantizationAware::load(const std::vector<double>& values, const TrainState& state) {
  const bool attached = state.attached.contains(kSensitivity);
  if (values.empty()) {
    steps_.reset();
    if (!attached) return {};
  }
  const auto positive = [](double v) { return v > 0 && std::isfinite(v); };
  const auto rows_are = [&](const char* key, std::size_t rows) {
    const auto found = state.attached.find(key);
    return found != state.attached.end() &&
           static_cast<std::size_t>(found->second.values.rows()) == rows;
  };
  const int degree = sh_degree_of(state.parameters);
  if (values.size() != 7 || !std::ranges::all_of(values, positive) ||
      !rows_are(kSensitivity, sensitivity_size(degree)) ||
      !rows_are(kQuantizationOffsets, static_cast<std::size_t>(state.parameters.rows())))
    return fail("", name(), "expected 7 step sizes, sensitivities and offsets");
  const auto f = [&](std::size_t i) { return static_cast<float>(values[i]); };
  steps_ = QuantizationSteps{values[0], f(1), f(2), f(3), f(4), f(5), f(6)};
  return {};
}

}  // namespace

OptionFields QuantizationAwareOptions::fields(const TrainOptions&) {
  const bool on = mode != QuantizeAware::off;
  return {choice("quantize-aware",
                 "train on with the values that a compact file holds (auto: where OUT is a "
                 ".glb)",
                 mode, kQuantizeAwareNames)
              .only_if(!on || !has_networks, "a training without networks (--psi, --phi)"),
          whole("quantize-from",
                "first iteration of quantization-aware training, after densification and the "
                "SH reduction (0: 9/10 of the iterations)",
                from, 0, kUnlimited)
              .only_if(on, "--quantize-aware on"),
          whole("quantize-interval",
                "iterations until values are quantized anew (0: a thousandth of the "
                "iterations, at least 40)",
                interval, 0, kUnlimited)
              .only_if(on, "--quantize-aware on")};
}

void attach_sensitivity(TrainState& state, const SensitivityWeights& sensitivity) {
  const int degree = sh_degree_of(state.parameters);
  const std::size_t size = state.parameters.size();
  PlanarFloats values(static_cast<int>(sensitivity_size(degree)), size);
  int row = 0;
  visit_lists(sensitivity, degree, [&](const auto& list, std::size_t each) {
    for (std::size_t k = 0; k < each; ++k, ++row)
      for (std::size_t i = 0; i < size && !list.empty(); ++i)
        values.row(row)[i] = list[i * each + k];
  });
  state.attached[kSensitivity] = {std::move(values)};
}

Expected<std::vector<std::byte>> quantize_parameters(TrainState& state,
                                                     const QuantizationSteps& steps,
                                                     const ScreenFilter& filter) {
  const int degree = sh_degree_of(state.parameters);
  PlanarFloats exact = state.parameters;
  if (const auto offsets = state.attached.find(kQuantizationOffsets);
      offsets != state.attached.end())
    add(exact, offsets->second.values, -1);
  SplatCloud cloud = to_cloud(exact, degree);
  cloud.filter = filter;
  // Offsets must be between quaternions that mean the same of four half turns
  canonicalize_rotations(cloud);
  const CompactOptions options{.steps = steps, .sensitivity = attached_sensitivity(state)};
  auto file = encode_compact_glb(cloud, options, kCompactFileName);
  if (!file) return std::unexpected(file.error());
  const auto stored = read_glb(*file, kCompactFileName);
  if (!stored) return std::unexpected(stored.error());
  if (stored->cloud.size() != cloud.size())
    return fail(kCompactFileName, "splats", "not all of them are finite");
  follow_rotations(exact, cloud.rotations, state.adam);
  const std::vector<std::uint32_t> order = compact_order(cloud, options);
  rearrange(state, order, order);
  state.parameters = to_parameters(stored->cloud, degree);
  PlanarFloats offsets = state.parameters;
  add(offsets, to_parameters(in_order(cloud, order), degree), -1);
  state.attached[kQuantizationOffsets] = {std::move(offsets)};
  return file;
}

std::unique_ptr<Phase> make_quantization_aware(TrainOptions& options, int settled) {
  auto& own = options.get<QuantizationAwareOptions>();
  if (own.mode == QuantizeAware::off || own.has_networks) return nullptr;
  if (own.mode == QuantizeAware::automatic && !options.compact_output) return nullptr;
  const int asked = own.from;
  resolve(own.from, options.iterations / 10 * 9);
  resolve(own.interval, std::max(options.iterations / 1000, 40));
  own.from = std::max(own.from, settled + 1);
  options.get<CompressionOptions>().used = true;
  return std::make_unique<QuantizationAware>(own, asked, options.iterations,
                                             options.render.filter.value_or(ScreenFilter{}));
}

}  // namespace fluxgs
