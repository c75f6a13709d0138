#include "codec/compact.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <ranges>
#include <utility>

#include <fmt/format.h>

#include "cloud/activation.h"
#include "cloud/cloud_memory.h"
#include "cloud/gather.h"
#include "codec/beside.h"
#include "codec/channels.h"
#include "codec/deterministic_math.h"
#include "codec/perceptual_weight.h"
#include "codec/positions.h"
#include "codec/quantization.h"
#include "codec/rotations.h"
#include "codec/scales.h"
#include "codec/sh.h"
#include "codec/stored_sensitivity.h"
#include "codec/vectors.h"
#include "fluxgs/byte_reader.h"

namespace fluxgs::codec {
namespace {

// What an image cannot tell apart from 0 and 1: opacities below 1/255 are not drawn, those above
// 0.99 are cut there (render_options.h)
constexpr double kMinOpacity = 1e-3, kMaxOpacity = 1 - 1e-3;

/// The other way round than opacity_scale(). Clamping has branches, and loops of its own: the
/// others are vectorised.
void store_opacities(std::span<const float> scales, std::span<float> logits) {
  std::vector<double> x(scales.begin(), scales.end());
  for (double& v : x) v = std::clamp(v, 0.0, 1.0);
  for (double& v : x) {
    const double root = portable_sin(v * std::numbers::pi / 2);
    v = root * root;
  }
  for (double& v : x) v = std::clamp(v, kMinOpacity, kMaxOpacity);
  for (std::size_t i = 0; i < x.size(); ++i)
    logits[i] = static_cast<float>(portable_log(x[i]) - portable_log(1 - x[i]));
}

// Each attribute may rest on those before it: their decoded values tell how exactly it is stored.
enum Attribute : std::size_t { kPosition, kScale, kOpacity, kRotation, kDc, kRest, kEnergy };
constexpr const char* kNames[] = {"position", "scale",   "opacity", "rotation",
                                  "sh_dc",    "sh_rest", "energy"};

/// The weight that varies the steps of an attribute from splat to splat; scales have none.
const PerceptualWeight* perceptual_weight_of(Attribute attribute) {
  if (attribute == kScale) return nullptr;
  if (attribute == kOpacity) return &kOpacityWeight;
  return attribute == kRotation ? &kRotationWeight : &kColorWeight;
}

/// Contents of a stream, as far as they are decoded.
struct Content {
  SplatCloud cloud;
  bool has_energy = false;
  std::vector<float> energy = {};
  std::vector<LogExtents> extents = {};
  const PerceptualWeight* weight = nullptr;  ///< of the step scale that was asked for last
  std::vector<float> step_scale = {};

  /// To be called when `attribute` is there.
  void note(Attribute attribute) {
    if (attribute == kScale) extents = extents_of(cloud.log_scales);
    if (attribute == kOpacity) set_opacities(extents, cloud.opacity_logits);
    if (attribute == kScale || attribute == kOpacity) weight = nullptr;
  }
  /// Valid until the next call. All colours have the same.
  std::span<const float> step_scale_of(Attribute attribute) {
    const PerceptualWeight* wanted = perceptual_weight_of(attribute);
    if (wanted == nullptr) return {};
    if (wanted != weight) step_scale = codec::step_scale_of(*wanted, extents);
    weight = wanted;
    return step_scale;
  }
};

/// In the order of the stream, behind the positions.
std::vector<Attribute> attributes_of(bool has_energy, int sh_degree) {
  if (has_energy) return {kScale, kOpacity, kRotation, kEnergy};
  if (sh_degree == 0) return {kScale, kOpacity, kRotation, kDc};
  return {kScale, kOpacity, kRotation, kDc, kRest};
}

std::size_t channels_of(Attribute attribute, int sh_degree) {
  if (attribute == kOpacity) return 1;
  if (attribute == kEnergy) return kEnergyChannels;
  return attribute == kRest ? 3 * static_cast<std::size_t>(sh_rest_count(sh_degree)) : 3;
}

float step_of(Attribute attribute, const QuantizationSteps& steps) {
  const float by_attribute[] = {0,           steps.log_scale, steps.opacity, steps.rotation,
                                steps.sh_dc, steps.sh_rest,   steps.energy};
  return by_attribute[attribute];
}

double factor_of(Attribute attribute, const RateFactors& rates) {
  if (attribute == kScale) return rates.scale;
  if (attribute == kOpacity) return rates.opacity;
  return attribute == kRotation ? rates.rotation : rates.color;
}

/// The attributes that are three values, or a multiple of them, as they are.
std::vector<glm::vec3>& vectors_of(Attribute attribute, SplatCloud& cloud) {
  return attribute == kScale ? cloud.log_scales : attribute == kDc ? cloud.sh_dc : cloud.sh_rest;
}

void put_vec3(std::vector<float>& out, const glm::vec3& v) {
  for (int c = 0; c < 3; ++c) out.push_back(v[c]);
}

/// All but the scales.
std::vector<float> values_of(Attribute attribute, Content& content) {
  if (attribute == kEnergy) return content.energy;
  SplatCloud& cloud = content.cloud;
  std::vector<float> out;
  out.reserve(cloud.size() * channels_of(attribute, cloud.sh_degree));
  if (attribute == kOpacity)
    for (const float logit : cloud.opacity_logits) out.push_back(opacity_scale(logit));
  else if (attribute == kRotation)
    for (const glm::quat& q : cloud.rotations) put_vec3(out, reduced_rotation(q));
  else
    for (const glm::vec3& v : vectors_of(attribute, cloud)) put_vec3(out, v);
  return out;
}

/// Values that lie channel by channel.
struct AttributePlanes {
  std::span<const float> values;
  std::size_t splats;

  float at(std::size_t channel, std::size_t splat) const {
    return values[channel * splats + splat];
  }
  glm::vec3 vec3(std::size_t first, std::size_t splat) const {
    return {at(first, splat), at(first + 1, splat), at(first + 2, splat)};
  }
};

void store(Attribute attribute, const AttributePlanes& from, Content& content) {
  SplatCloud& cloud = content.cloud;
  if (attribute == kOpacity) {
    store_opacities(from.values, cloud.opacity_logits);
  } else if (attribute == kRotation) {
    for (std::size_t i = 0; i < from.splats; ++i)
      cloud.rotations[i] = full_rotation(from.vec3(0, i));
  } else if (attribute == kEnergy) {
    content.energy.resize(from.values.size());
    for (std::size_t i = 0; i < from.splats; ++i)
      for (std::size_t c = 0; c < kEnergyChannels; ++c)
        content.energy[i * kEnergyChannels + c] = from.at(c, i);
  } else {
    auto& vectors = vectors_of(attribute, cloud);
    const std::size_t each = vectors.size() / from.splats;
    for (std::size_t i = 0; i < from.splats; ++i)
      for (std::size_t k = 0; k < each; ++k) vectors[i * each + k] = from.vec3(3 * k, i);
  }
}

std::unexpected<Error> in_attribute(Attribute attribute, const Error& error) {
  return fail("", kNames[attribute], error.message());
}

/// Weights of errors in steps: those of a coarse splat are larger. 1 on the average.
std::vector<float> quantization_weights(std::span<const float> weights,
                                        std::span<const float> step_scale) {
  if (weights.empty()) return {};
  std::vector<float> result(weights.size());
  double sum = 0;
  for (std::size_t k = 0; k < weights.size(); ++k) {
    const double c = step_scale.empty() ? 1.0 : double{step_scale[k]};
    sum += double{result[k] = static_cast<float>(double{weights[k]} * c * c)};
  }
  if (!(sum > 0)) return {};
  const double mean = sum / static_cast<double>(weights.size());
  for (float& weight : result)
    weight = static_cast<float>(std::clamp(double{weight} / mean, kMinWeight, kMaxWeight));
  return result;
}

Expected<std::span<const std::byte>> take_section(ByteReader& in, Attribute attribute) {
  const auto size = in.take_varint();
  const auto bytes = size ? in.take_bytes(*size) : std::nullopt;
  if (!bytes) return fail("", kNames[attribute], "is cut off");
  return *bytes;
}

void put_section(Bytes& out, const Bytes& section) {
  put_varint(out, section.size());
  out.insert(out.end(), section.begin(), section.end());
}

struct Section {
  Attribute attribute;
  std::span<const std::byte> bytes;
};

/// Decodes a section into the content, in which the attributes that it rests on are decoded
/// already. `room` is used again for each.
Expected<void> decode_section(const Section& section, std::span<const float> step_scale,
                              Content& content, std::vector<float>& room) {
  const auto& [attribute, bytes] = section;
  const std::size_t channels = channels_of(attribute, content.cloud.sh_degree);
  const std::size_t count = channels * content.cloud.size();
  if (room.size() < count) room = std::vector<float>(count);
  const auto values = std::span(room).first(count);
  ByteReader in(bytes);
  const auto step = decode_channels(in, channels, step_scale, values);
  if (!step) return in_attribute(attribute, step.error());
  if (in.left() > 0) return fail("", kNames[attribute], "has bytes left over");
  if (attribute == kScale) roots_to_logs(values, *step);
  store(attribute, {values, content.cloud.size()}, content);
  content.note(attribute);
  return {};
}

/// Those behind the positions.
struct Sections {
  std::vector<Section> there;
  Expected<void> end;  ///< an error where one is cut off, or something is left over
};

Sections take_sections(ByteReader& in, const Content& content) {
  Sections sections;
  for (const Attribute attribute : attributes_of(content.has_energy, content.cloud.sh_degree)) {
    const auto section = take_section(in, attribute);
    if (!section) return {std::move(sections.there), std::unexpected(section.error())};
    sections.there.push_back({attribute, *section});
  }
  const auto padding = *in.take_bytes(in.left());
  if (std::ranges::any_of(padding, [](std::byte b) { return b != std::byte{0}; }))
    sections.end = fail("", "", "bytes other than zeros are left over behind the last attribute");
  return sections;
}

/// Fewer are decoded before another thread has begun.
constexpr std::size_t kManySplats = 10'000;

/// Decodes them; the last, most of the colours, beside those that it does not rest on. That is safe
/// as each writes its own vector of the content, and note() acts on scales and opacities alone.
Expected<void> decode_sections(const Sections& sections, Content& content) {
  const std::span all(sections.there);
  std::vector<float> room;
  const auto decode = [&](const Section& section) {
    return decode_section(section, content.step_scale_of(section.attribute), content, room);
  };
  // Scales and opacities, on which others rest; of a damaged stream all, to find its first error
  for (const Section& section : all.first(sections.end ? 2 : all.size()))
    if (auto ok = decode(section); !ok) return ok;
  if (!sections.end) return sections.end;
  const Section& last = all.back();
  const std::span<const float> scale = content.step_scale_of(last.attribute);
  Beside colours(content.cloud.size() >= kManySplats,
                 [&, scale = std::vector<float>(scale.begin(), scale.end()),
                  room = std::vector<float>()]() mutable {
                   return decode_section(last, scale, content, room);
                 });
  for (const Section& section : all.subspan(2, all.size() - 3) | std::views::reverse)
    if (auto ok = decode(section); !ok) return ok;
  return colours.result();
}

Expected<void> decode_position_section(std::span<const std::byte> section, CellCoding cells,
                                       std::span<glm::vec3> positions) {
  ByteReader in(section);
  if (auto ok = decode_positions(in, cells, positions); !ok) return ok;
  if (in.left() > 0) return fail("", kNames[kPosition], "has bytes left over");
  return {};
}

/// An attribute on its way into a stream.
struct Input {
  Channels channels;
  float step = 1;
  double rate_weight = 0;
  std::vector<float> weights;

  RateDistortion rate_distortion() const { return {rate_weight, weights}; }
};

/// The section sh_rest of colours that are quantized together (sh.h); those of degree 0
/// become what goes best with it.
Expected<Bytes> encode_rest(const Input& rest, std::span<const float> factors,
                            std::vector<glm::vec3>& sh_dc) {
  std::vector<float> dc;
  for (const glm::vec3& v : sh_dc) put_vec3(dc, v);
  Bytes section;
  if (auto ok = encode_sh(rest.channels, factors, rest.step, rest.rate_distortion(), dc, section);
      !ok)
    return in_attribute(kRest, ok.error());
  for (std::size_t i = 0; i < sh_dc.size(); ++i)
    sh_dc[i] = {dc[3 * i], dc[3 * i + 1], dc[3 * i + 2]};
  return section;
}

class Encoder {
 public:
  Encoder(const SplatCloud& cloud, const CompactOptions& options, std::span<const float> energy,
          const RateFactors& rates)
      : Encoder(cloud, options, energy, rates,
                position_order(cloud.positions, options.steps.position)) {}

  Expected<Bytes> run() {
    Bytes out, section;
    std::vector<float> room;
    if (auto ok = encode_positions(source_.cloud.positions, options_.steps.position, section); !ok)
      return std::unexpected(ok.error());
    put_section(out, section);
    for (const Attribute attribute : attributes_of(source_.has_energy, source_.cloud.sh_degree)) {
      const auto encoded = section_of(attribute);
      if (!encoded) return std::unexpected(encoded.error());
      put_section(out, *encoded);
      if (attribute != kScale && attribute != kOpacity) continue;  // nothing rests on it
      if (auto ok = decode_section({attribute, *encoded}, decoded_.step_scale_of(attribute),
                                   decoded_, room);
          !ok)
        return std::unexpected(ok.error());
    }
    while (source_.cloud.size() > max_splats(out.size())) out.push_back(std::byte{0});
    return out;
  }

 private:
  Encoder(const SplatCloud& cloud, const CompactOptions& options, std::span<const float> energy,
          const RateFactors& rates, const std::vector<std::uint32_t>& order)
      : options_(options),
        rates_(rates),
        source_{fluxgs::in_order(cloud, order), !energy.empty(),
                io::gather(energy, order, kEnergyChannels, kEnergyChannels)},
        decoded_(source_),
        sensitivity_(sensitivity_of(options.sensitivity, cloud.sh_degree, order, cloud.sh_degree)) {
  }

  Expected<Bytes> section_of(Attribute attribute) {
    const bool has_factors = source_.cloud.sh_degree > 0 && !sensitivity_.sh_factors.empty();
    if (attribute == kDc && has_factors) {
      auto rest = encode_rest(input_of(kRest), sensitivity_.sh_factors, source_.cloud.sh_dc);
      if (!rest) return rest;
      rest_ = std::move(*rest);
    }
    if (attribute == kRest && has_factors) return std::move(rest_);
    const Input input = input_of(attribute);
    const std::vector<float> sensitivity = stored_sensitivity(attribute);
    Bytes section;
    const auto ok =
        sensitivity.empty()
            ? encode_channels(input.channels, input.step, input.rate_distortion(), section)
            : encode_vectors(input.channels, sensitivity, input.step, input.rate_weight, section);
    if (!ok) return in_attribute(attribute, ok.error());
    return section;
  }

  Input input_of(Attribute attribute) {
    const std::span<const float> scale = decoded_.step_scale_of(attribute);
    std::vector<float> step_scale(scale.begin(), scale.end());
    std::vector<float> weights = quantization_weights(sensitivity_.weights, step_scale);
    Stepped stepped =
        attribute == kScale
            ? roots_of(source_.cloud.log_scales, options_.steps.log_scale)
            : Stepped{values_of(attribute, source_), step_of(attribute, options_.steps)};
    return {.channels = {channels_of(attribute, source_.cloud.sh_degree), std::move(stepped.values),
                         std::move(step_scale)},
            .step = stepped.step,
            .rate_weight = options_.rate_weight * factor_of(attribute, rates_),
            .weights = std::move(weights)};
  }

  std::vector<float> stored_sensitivity(Attribute attribute) const {
    if (attribute == kScale)
      return sensitivity_of_roots(sensitivity_.scale, source_.cloud.log_scales);
    if (attribute == kRotation)
      return sensitivity_of_rotations(sensitivity_.rotation, source_.cloud.rotations);
    return {};
  }

  const CompactOptions& options_;
  const RateFactors& rates_;
  Content source_;   ///< in the order of the file
  Content decoded_;  ///< what later attributes rest on is as it will be read
  SensitivityWeights sensitivity_;
  Bytes rest_;
};

}  // namespace

glm::quat canonical_rotation(const glm::quat& rotation) {
  return full_rotation(reduced_rotation(rotation));
}

float opacity_scale(float logit) {
  const double root = std::sqrt(double{io::opacity_of(logit)});
  return static_cast<float>(std::asin(root) * 2 / std::numbers::pi);
}

Expected<Bytes> encode_compact(const SplatCloud& cloud, const CompactOptions& options,
                               std::span<const float> energy, const RateFactors& rates) {
  if (cloud.size() == 0) return Bytes();
  return Encoder(cloud, options, energy, rates).run();
}

Expected<SplatCloud> decode_compact(std::span<const std::byte> bytes, std::size_t count,
                                    int sh_degree, std::vector<float>* energy, CellCoding cells) {
  if (count > max_splats(bytes.size()))
    return fail("", "",
                fmt::format("{} splats in {} bytes, expected {} at most", count, bytes.size(),
                            max_splats(bytes.size())));
  if (count == 0 && !bytes.empty())
    return fail("", "", fmt::format("{} bytes for no splats, expected none", bytes.size()));
  auto cloud = io::allocate_cloud(count, sh_degree, "");
  if (!cloud || count == 0) return cloud;
  Content content{std::move(*cloud), energy != nullptr};
  ByteReader in(bytes);
  const auto section = take_section(in, kPosition);
  if (!section) return std::unexpected(section.error());
  const Sections sections = take_sections(in, content);
  // Nothing rests on positions
  Beside positions(count >= kManySplats, [&] {
    return decode_position_section(*section, cells, content.cloud.positions);
  });
  const auto others = decode_sections(sections, content);
  if (auto ok = positions.result(); !ok) return std::unexpected(ok.error());
  if (!others) return std::unexpected(others.error());
  if (energy != nullptr) *energy = std::move(content.energy);
  return std::move(content.cloud);
}

Expected<std::vector<std::pair<std::string, std::size_t>>> attribute_bytes(
    std::span<const std::byte> bytes, int sh_degree, bool has_energy) {
  std::vector<Attribute> attributes = attributes_of(has_energy, sh_degree);
  attributes.insert(attributes.begin(), kPosition);
  ByteReader in(bytes);
  std::vector<std::pair<std::string, std::size_t>> sizes;
  if (bytes.empty()) return sizes;
  for (const Attribute attribute : attributes) {
    const auto section = take_section(in, attribute);
    if (!section) return std::unexpected(section.error());
    sizes.emplace_back(kNames[attribute], section->size());
  }
  return sizes;
}

}  // namespace fluxgs::codec
