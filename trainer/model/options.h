// The options of a training: what every run has, and one group of options for each phase.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/render_options.h"

namespace fluxgs {

struct TrainOptions;

/// The values that an enumeration has, by name.
struct OptionChoice {
  std::span<const std::string_view> names;
  std::function<int()> get;
  std::function<void(int)> set;
};

/// One option by its name on the command line, in reports and in checkpoints, bound to where its
/// value lies.
struct OptionField {
  const char* name;  ///< without dashes
  const char* help;  ///< one sentence without a full stop
  std::variant<int*, double*, std::uint64_t*, bool*, OptionChoice> value;
  double low = 0, high = 0;  ///< accepted range of a number
  std::string needs = {};    ///< what the option needs to have an effect, if it has none now
  std::string_view group = {};

  /// Puts the option beside those of a phase.
  OptionField&& in_group(std::string_view title) && {
    group = title;
    return std::move(*this);
  }
  /// Marks the option as ineffective unless `condition` holds.
  OptionField&& only_if(bool condition, std::string_view needed) && {
    if (!condition && needs.empty()) needs = needed;
    return std::move(*this);
  }
};

using OptionFields = std::vector<OptionField>;

inline constexpr double kUnlimited = 1e9;

OptionField whole(const char* name, const char* help, int& value, double low, double high);
OptionField real(const char* name, const char* help, double& value, double low, double high);
OptionField natural(const char* name, const char* help, std::uint64_t& value);
OptionField flag(const char* name, const char* help, bool& value);

template <class Enum, std::size_t n>
OptionField choice(const char* name, const char* help, Enum& value,
                   const std::array<std::string_view, n>& names) {
  return {.name = name,
          .help = help,
          .value = OptionChoice{names, [&value] { return static_cast<int>(value); },
                                [&value](int i) { value = static_cast<Enum>(i); }},
          .high = n - 1.0};
}

/// A phase's options, as the list of all options sees them. A group T is a plain struct with
///   static constexpr const char* kTitle;            // of the phase
///   OptionFields fields(const TrainOptions& all);   // bound to this object
///   Expected<void> validate(const TrainOptions&) const;  // beyond the ranges; may be missing
class OptionGroup {
 public:
  virtual ~OptionGroup() = default;
  virtual const char* title() const = 0;
  virtual OptionFields fields(const TrainOptions& all) = 0;
  virtual Expected<void> validate(const TrainOptions& all) const = 0;
  virtual std::unique_ptr<OptionGroup> clone() const = 0;
};

template <class T>
class OptionGroupOf final : public OptionGroup {
 public:
  T options;
  const char* title() const override { return T::kTitle; }
  OptionFields fields(const TrainOptions& all) override { return options.fields(all); }
  Expected<void> validate(const TrainOptions& all) const override {
    if constexpr (requires { options.validate(all); }) return options.validate(all);
    return {};
  }
  std::unique_ptr<OptionGroup> clone() const override {
    return std::make_unique<OptionGroupOf>(*this);
  }
};

/// Options of every run. Defaults are those of vanilla
/// 3DGS (Kerbl et al. 2023, section 5 and appendix), but for the opacity rate (0.05 there in the
/// first release). Presets (train/schedule.h) change them. "Paper" is the Flux-GS paper.
///
/// An iteration or interval of 0 means "depends on the length of the run" where its help says so;
/// make_schedule() replaces it.
struct CommonOptions {
  int iterations = 30000;
  std::uint64_t seed = 1;
  int sh_degree = 3;  ///< 0…3

  // Learning rates of Adam, per iteration
  double position_lr = 1.6e-4;        ///< × scene extent, at the start
  double position_lr_final = 1.6e-6;  ///< × scene extent, after position_lr_iterations; log-linear
  double cooldown = 0;       ///< 0…1: share of the run, at its end, in which all rates fall
  double cooldown_to = 0.1;  ///< 0…1: the factor that they fall to, log-linear
  int position_lr_iterations = 30000;  ///< fixed in 3DGS, so that short runs end with a higher rate
  double sh_dc_lr = 2.5e-3;            ///< of SH coefficients
  double sh_rest_lr = 2.5e-3 / 20;
  double opacity_lr = 0.025;  ///< of logits
  double scale_lr = 5e-3;     ///< of natural logarithms; 0: depends on the length of the run
  double rotation_lr = 1e-3;  ///< of quaternions' components
  double beta1 = 0.9, beta2 = 0.999, epsilon = 1e-15;

  double lambda_dssim = 0.2;  ///< weight of 1 − SSIM in the loss, 0…1

  std::uint64_t max_splats = 0;      ///< 0: no limit
  std::uint64_t max_memory = 0;      ///< MiB of the program, by estimate; 0: no limit
  std::uint64_t target_splats = 0;   ///< splats at the end, whatever the gradients; 0: no target
  std::uint64_t initial_splats = 0;  ///< every n-th point, so that they are this many; 0: all
  double initial_opacity = 0.1;      ///< 0…1

  /// RenderOptions::depth_spread_max of the training's renders; 0: no limit, as in 3DGS. The
  /// default is that of every renderer here, so that a scene is shown as it was trained.
  double depth_spread = RenderOptions().depth_spread_max;
  RenderOptions render;
  bool compact_output = true;  ///< the result is stored as a compact file; no option of its own
};

/// All options of a run: the common ones, and the groups of the phases behind get().
struct TrainOptions : CommonOptions {
  /// The group T; made with its defaults if there is none yet.
  template <class T>
  T& get() {
    for (auto& group : groups_)
      if (auto* found = dynamic_cast<OptionGroupOf<T>*>(group.get())) return found->options;
    groups_.push_back(std::make_unique<OptionGroupOf<T>>());
    return static_cast<OptionGroupOf<T>&>(*groups_.back()).options;
  }
  template <class T>
  const T& get() const {
    for (const auto& group : groups_)
      if (auto* found = dynamic_cast<const OptionGroupOf<T>*>(group.get())) return found->options;
    static const T defaults;
    return defaults;
  }

  /// All options, bound to this object: those of every run first, then group by group.
  OptionFields fields();
  /// Checks ranges, then what options ask of each other; the error names the option.
  Expected<void> validate() const;

  TrainOptions() = default;
  TrainOptions(const TrainOptions& other);
  TrainOptions(TrainOptions&&) = default;
  TrainOptions& operator=(const TrainOptions& other);
  TrainOptions& operator=(TrainOptions&&) = default;

 private:
  std::vector<std::unique_ptr<OptionGroup>> groups_;
};

/// The field's value as one types it.
std::string text_of(const OptionField& field);

/// Sets a field from what was typed. The error names the option and what was expected.
Expected<void> set(OptionField& field, std::string_view text);

/// Replaces a value of 0 by an alternative of at least 1.
inline void resolve(int& value, int alternative) {
  if (value == 0) value = std::max(alternative, 1);
}

}  // namespace fluxgs
