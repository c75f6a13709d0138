#include "trainer/model/options.h"

#include <charconv>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "trainer/model/whole_number.h"

namespace fluxgs {
namespace {

constexpr std::array<std::string_view, 2> kOffOn = {"off", "on"};

OptionFields own_fields(TrainOptions& o) {
  return {
      whole("iterations", "training iterations", o.iterations, 1, kUnlimited),
      natural("seed", "random seed", o.seed),
      natural("max-splats", "maximum number of splats (0: no limit)", o.max_splats),
      natural("target-splats",
              "number of splats to end with, whatever the gradients (0: no target)",
              o.target_splats)
          .in_group("Densification"),
      natural("max-memory", "MiB that training may take; no splats are added beyond (0: no limit)",
              o.max_memory),
      whole("sh-degree", "SH degree", o.sh_degree, 0, 3),
      real("position-lr", "learning rate of positions, x scene extent", o.position_lr, 0, 1),
      real("position-lr-final", "final learning rate of positions, x scene extent",
           o.position_lr_final, 1e-12, 1),
      whole("position-lr-iterations", "iterations over which the learning rate of positions falls",
            o.position_lr_iterations, 1, kUnlimited),
      real("sh-dc-lr", "learning rate of SH coefficients of degree 0", o.sh_dc_lr, 0, 1),
      real("sh-rest-lr", "learning rate of the other SH coefficients", o.sh_rest_lr, 0, 1),
      real("opacity-lr", "learning rate of opacity logits", o.opacity_lr, 0, 10),
      real(
          "scale-lr",
          "learning rate of log-scales (0: 0.02 for 7,000 iterations or fewer, the more the lower, "
          "down to 0.005)",
          o.scale_lr, 0, 1),
      real("rotation-lr", "learning rate of quaternions", o.rotation_lr, 0, 1),
      real("cooldown", "share of the run, at its end, in which all learning rates fall", o.cooldown,
           0, 1),
      real("cooldown-to", "factor that learning rates fall to in the cooldown", o.cooldown_to, 1e-6,
           1)
          .only_if(o.cooldown > 0, "a --cooldown of more than 0"),
      real("beta1", "Adam: decay of the first moment", o.beta1, 0, 0.999999),
      real("beta2", "Adam: decay of the second moment", o.beta2, 0, 0.9999999),
      real("epsilon", "Adam: term added to the denominator", o.epsilon, 1e-30, 1),
      real("lambda-dssim", "weight of 1 - SSIM in the loss", o.lambda_dssim, 0, 1),
      natural("initial-splats", "maximum number of initial splats (0: one for each point)",
              o.initial_splats),
      real("initial-opacity", "opacity of the initial splats", o.initial_opacity, 1e-3, 0.99),
      real("depth-spread",
           "maximum extent of a drawn splat along the view, x its depth (0: no maximum)",
           o.depth_spread, 0, kUnlimited),
  };
}

double number_in(const OptionField& f) {
  if (auto* const* p = std::get_if<int*>(&f.value)) return **p;
  if (auto* const* p = std::get_if<double*>(&f.value)) return **p;
  if (auto* const* p = std::get_if<std::uint64_t*>(&f.value)) return static_cast<double>(**p);
  if (auto* const* p = std::get_if<bool*>(&f.value)) return **p;
  return std::get<OptionChoice>(f.value).get();
}

template <class Number>
bool parse(std::string_view text, Number& value) {
  const auto [rest, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  return status == std::errc() && rest == text.data() + text.size();
}

/// `value` in the place of the name among `names`; false if it is not there.
bool find_name(std::span<const std::string_view> names, std::string_view text, int& value) {
  const auto at = std::ranges::find(names, text);
  value = static_cast<int>(at - names.begin());
  return at != names.end();
}

bool assign(OptionField& f, std::string_view text) {
  if (auto** p = std::get_if<int*>(&f.value)) {
    const auto number = whole_number(text);
    if (!number || std::abs(*number) > kUnlimited) return false;
    **p = static_cast<int>(*number);
    return true;
  }
  if (auto** p = std::get_if<double*>(&f.value)) return parse(text, **p);
  if (auto** p = std::get_if<std::uint64_t*>(&f.value)) {
    if (parse(text, **p)) return true;
    const auto number = whole_number(text);
    if (!number || *number < 0) return false;
    **p = static_cast<std::uint64_t>(*number);
    return true;
  }
  int index = 0;
  if (auto** p = std::get_if<bool*>(&f.value)) {
    if (!find_name(kOffOn, text, index)) return false;
    **p = index == 1;
    return true;
  }
  auto& choice = std::get<OptionChoice>(f.value);
  if (!find_name(choice.names, text, index)) return false;
  choice.set(index);
  return true;
}

std::string expected(const OptionField& f) {
  if (std::holds_alternative<bool*>(f.value)) return "expected off or on";
  if (const auto* c = std::get_if<OptionChoice>(&f.value))
    return fmt::format("expected one of {}", fmt::join(c->names, ", "));
  if (std::holds_alternative<std::uint64_t*>(f.value))
    return "expected a whole number from 0 to 2^64 - 1";
  return fmt::format("expected {}{:.10g} to {:.10g}",
                     std::holds_alternative<int*>(f.value) ? "a whole number from " : "", f.low,
                     f.high);
}

bool in_range(const OptionField& f) {
  if (std::holds_alternative<std::uint64_t*>(f.value)) return true;
  const double value = number_in(f);
  return value >= f.low && value <= f.high;  // false for NaN
}

}  // namespace

OptionField whole(const char* name, const char* help, int& value, double low, double high) {
  return {.name = name, .help = help, .value = &value, .low = low, .high = high};
}
OptionField real(const char* name, const char* help, double& value, double low, double high) {
  return {.name = name, .help = help, .value = &value, .low = low, .high = high};
}
OptionField natural(const char* name, const char* help, std::uint64_t& value) {
  return {.name = name, .help = help, .value = &value, .high = 1.9e19};
}
OptionField flag(const char* name, const char* help, bool& value) {
  return {.name = name, .help = help, .value = &value, .high = 1};
}

TrainOptions::TrainOptions(const TrainOptions& other) { *this = other; }

TrainOptions& TrainOptions::operator=(const TrainOptions& other) {
  if (this == &other) return *this;
  const auto copy = [](const auto& groups) {
    std::vector<std::unique_ptr<OptionGroup>> copies;
    for (const auto& group : groups) copies.push_back(group->clone());
    return copies;
  };
  auto groups = copy(other.groups_);
  static_cast<CommonOptions&>(*this) = other;
  groups_ = std::move(groups);
  return *this;
}

OptionFields TrainOptions::fields() {
  OptionFields all = own_fields(*this);
  for (OptionField& field : all)
    if (field.group.empty()) field.group = "All runs";
  for (const auto& group : groups_)
    for (OptionField& field : group->fields(*this)) {
      field.group = group->title();
      all.push_back(std::move(field));
    }
  return all;
}

Expected<void> TrainOptions::validate() const {
  TrainOptions copy = *this;  // fields are bound to objects that may change
  for (const OptionField& f : copy.fields())
    if (!in_range(f))
      return fail("", fmt::format("--{}", f.name),
                  fmt::format("{} is out of range, {}", text_of(f), expected(f)));
  for (const auto& group : groups_)
    if (auto valid = group->validate(*this); !valid) return valid;
  return {};
}

std::string text_of(const OptionField& f) {
  if (auto* const* p = std::get_if<bool*>(&f.value)) return std::string(kOffOn[**p ? 1 : 0]);
  if (auto* const* p = std::get_if<std::uint64_t*>(&f.value)) return fmt::format("{}", **p);
  if (const auto* c = std::get_if<OptionChoice>(&f.value)) {
    const auto index = static_cast<std::size_t>(c->get());
    return index < c->names.size() ? std::string(c->names[index]) : fmt::format("{}", index);
  }
  return fmt::format("{:.9g}", number_in(f));
}

Expected<void> set(OptionField& field, std::string_view text) {
  if (assign(field, text) && in_range(field)) return {};
  return fail("", fmt::format("--{}", field.name), fmt::format("'{}': {}", text, expected(field)));
}

}  // namespace fluxgs
