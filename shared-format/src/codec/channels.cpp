#include "codec/channels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "codec/bits.h"
#include "codec/prediction.h"
#include "codec/rans.h"
#include "fluxgs/byte_reader.h"
#include "fluxgs/math/finite.h"

namespace fluxgs::codec {
namespace {

constexpr std::size_t kMaxChannels = 64;
constexpr float kLargestInHeader = 1e30f;  // so that no sum of products overflows

/// Multiples of the step, not yet whole, channel by channel.
using ChannelPlanes = std::vector<std::vector<double>>;

Eigen::MatrixXd matrix_of(const Channels& input) {
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto splats = static_cast<Eigen::Index>(input.splats());
  return Eigen::Map<const Rows>(input.values.data(), splats,
                                static_cast<Eigen::Index>(input.channels))
      .cast<double>();
}

std::vector<float> mean_of(const Eigen::MatrixXd& x) {
  const Eigen::VectorXf mean = x.colwise().mean().transpose().cast<float>();
  return {mean.begin(), mean.end()};
}

/// Eigenvectors of the covariance, the largest eigenvalue first.
std::vector<float> principal_axes(const Eigen::MatrixXd& x) {
  const Eigen::MatrixXd centered = x.rowwise() - x.colwise().mean();
  const Eigen::MatrixXd covariance = centered.transpose() * centered;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
  const Eigen::MatrixXf axes = eigen.eigenvectors().rowwise().reverse().cast<float>();
  return {axes.data(), axes.data() + axes.size()};
}

Expected<ChannelPlanes> in_steps(const Channels& input, const Layout& t) {
  const std::size_t n = input.channels, splats = input.splats();
  ChannelPlanes planes(n, std::vector<double>(splats));
  std::vector<double> centered(n);
  for (std::size_t i = 0; i < splats; ++i) {
    const double step = double{t.step} * input.step_scale_of(i);
    for (std::size_t c = 0; c < n; ++c)
      centered[c] = double{input.values[i * n + c]} - double{t.mean[c]};
    for (std::size_t c = 0; c < n; ++c) {
      double z = centered[c];
      if (!t.basis.empty()) {
        z = 0;
        for (std::size_t k = 0; k < n; ++k) z += double{t.basis[c * n + k]} * centered[k];
      }
      z /= step;
      if (!(std::abs(z) < kMaxInteger))
        return fail("", "",
                    fmt::format("splat {}: its value over the step of {:g} is {:g}, expected less "
                                "than {:g}",
                                i, t.step, z, kMaxInteger));
      planes[c][i] = z;
    }
  }
  return planes;
}

/// Tells if differences from the prediction take fewer bits, and the bits of the channel, rounded
/// to the nearest, which tells well enough.
std::pair<bool, double> shorter_code(const std::vector<double>& plane) {
  const double plain = entropy_bits(quantize_cheaply(plane, false, {}));
  const double predicted = entropy_bits(quantize_cheaply(plane, true, {}));
  return {predicted < plain, std::min(predicted, plain)};
}

struct Choice {
  Layout layout;
  ChannelPlanes planes;
  double bits = 0;
};

Expected<Choice> choice_of(const Channels& input, Layout layout) {
  auto planes = in_steps(input, layout);
  if (!planes) return std::unexpected(planes.error());
  Choice choice{.layout = std::move(layout), .planes = std::move(*planes)};
  for (const auto& plane : choice.planes) {
    const auto [predicted, bits] = shorter_code(plane);
    choice.layout.predicted.push_back(predicted ? 1 : 0);
    choice.bits += bits;
  }
  choice.bits += 32.0 * static_cast<double>(choice.layout.basis.size());
  return choice;
}

Expected<Choice> choose(const Channels& input, float step) {
  const Eigen::MatrixXd x = matrix_of(input);
  const Layout plain{.step = step, .mean = mean_of(x)};
  for (const float mean : plain.mean)
    if (!(std::abs(mean) < kLargestInHeader))
      return fail("", "",
                  fmt::format("its mean is {:g}, expected less than {:g}", mean, kLargestInHeader));
  auto best = choice_of(input, plain);
  if (!best || input.channels == 1) return best;
  Layout turned = plain;
  turned.basis = principal_axes(x);
  auto other = choice_of(input, std::move(turned));
  return other && other->bits < best->bits ? other : best;
}

enum Kind : std::uint8_t { kPlain, kHasBasis, kHasAxes };

Expected<Layout> take_layout(ByteReader& in, std::size_t channels) {
  const auto stored = in.take_varint();
  if (stored && *stored != channels)
    return fail("", "", fmt::format("has {} channels, expected {}", *stored, channels));
  const auto kind = in.take<std::uint8_t>();
  const auto step = in.take<float>();
  if (!stored || !kind || !step) return fail("", "", "is cut off in its header");
  if (!(std::isfinite(*step) && *step > 0) || *kind > kHasAxes ||
      (*kind == kHasAxes && channels % 3 != 0))
    return fail("", "", "its header is damaged");
  Layout t{.step = *step, .mean = std::vector<float>(channels)};
  t.basis.resize(*kind == kHasBasis ? channels * channels : 0);
  t.axes.resize(*kind == kHasAxes ? 9 : 0);
  for (auto* list : {*kind == kHasAxes ? &t.axes : &t.mean, &t.basis})
    for (float& value : *list) {
      const auto number = in.take<float>();
      if (!number) return fail("", "", "is cut off in its header");
      if (!(std::abs(*number) < kLargestInHeader))
        return fail("", "", "its header has values out of range");
      value = *number;
    }
  BitReader bits(in);
  for (std::size_t c = 0; c < channels; ++c) {
    const auto predicted = bits.take(1);
    if (!predicted) return fail("", "", "is cut off in its header");
    t.predicted.push_back(static_cast<std::uint8_t>(*predicted));
  }
  return t;
}

constexpr std::size_t kBlock =
    64;  // splats that are restored together: loops that compilers vectorise

using Block = std::array<float, kBlock>;

/// z = step·k.
void scale_block(std::span<const float> steps, const float* k, Block& z) {
  for (std::size_t i = 0; i < steps.size(); ++i) z[i] = k[i] * steps[i];
}

/// to += factor·from.
void add_block(float factor, const Block& from, std::size_t count, Block& to) {
  for (std::size_t i = 0; i < count; ++i) to[i] += factor * from[i];
}

/// x = mean + basis·(step·k) for the splats from `first` on, kBlock of them at most; x, for which
/// there is room, takes the place of k.
void restore_block(const Layout& t, std::span<const float> steps, std::span<float> values,
                   std::size_t splats, std::size_t first, std::array<Block, kMaxChannels>& x) {
  const std::size_t n = t.mean.size(), count = steps.size();
  Block z;
  for (std::size_t c = 0; c < n; ++c) x[c].fill(t.mean[c]);
  for (std::size_t c = 0; c < n; ++c) {
    scale_block(steps, &values[c * splats + first], z);
    if (!t.basis.empty())
      for (std::size_t to = 0; to < n; ++to) add_block(t.basis[c * n + to], z, count, x[to]);
    else if (!t.axes.empty())
      for (std::size_t to = 0; to < 3; ++to)
        add_block(t.axes[c % 3 * 3 + to], z, count, x[c / 3 * 3 + to]);
    else
      add_block(1, z, count, x[c]);
  }
  for (std::size_t c = 0; c < n; ++c)
    std::copy_n(x[c].begin(), count,
                values.begin() + static_cast<std::ptrdiff_t>(c * splats + first));
}

void restore(const Layout& t, std::span<const float> step_scale, std::span<float> values,
             std::size_t splats) {
  std::array<float, kBlock> steps;
  std::array<Block, kMaxChannels> x;
  for (std::size_t first = 0; first < splats; first += kBlock) {
    const std::size_t count = std::min(kBlock, splats - first);
    for (std::size_t i = 0; i < count; ++i)
      steps[i] = t.step * (step_scale.empty() ? 1.0f : step_scale[first + i]);
    restore_block(t, std::span(steps).first(count), values, splats, first, x);
  }
}

}  // namespace

void encode_whole(const Layout& layout, const std::vector<std::vector<std::int32_t>>& planes,
                  Bytes& out) {
  put_varint(out, planes.size());
  put(out, static_cast<std::uint8_t>(!layout.axes.empty()    ? kHasAxes
                                     : !layout.basis.empty() ? kHasBasis
                                                             : kPlain));
  put(out, layout.step);
  for (const auto* list : {&layout.mean, &layout.basis, &layout.axes})
    for (const float value : *list) put(out, value);
  BitWriter bits(out);
  for (const std::uint8_t predicted : layout.predicted) bits.put(predicted, 1);
  bits.finish();
  encode_values(planes, out);
}

Expected<Layout> shortest_layout(const Channels& input, float step) {
  auto choice = choose(input, step);
  if (!choice) return std::unexpected(choice.error());
  return std::move(choice->layout);
}

Expected<void> encode_channels(const Channels& input, float step,
                               const RateDistortion& rate_distortion, Bytes& out) {
  const auto choice = choose(input, step);
  if (!choice) return std::unexpected(choice.error());
  std::vector<std::vector<std::int32_t>> planes;
  for (std::size_t c = 0; c < input.channels; ++c)
    planes.push_back(
        quantize_cheaply(choice->planes[c], choice->layout.predicted[c] != 0, rate_distortion));
  encode_whole(choice->layout, planes, out);
  return {};
}

Expected<double> channels_bits(const Channels& input, float step) {
  const auto choice = choose(input, step);
  if (!choice) return std::unexpected(choice.error());
  return choice->bits;
}

Expected<float> decode_channels(ByteReader& in, std::size_t channels,
                                std::span<const float> step_scale, std::span<float> values) {
  if (channels == 0 || channels > kMaxChannels)
    return fail("", "", fmt::format("{} channels, expected 1 to {}", channels, kMaxChannels));
  const std::size_t splats = values.size() / channels;
  if (splats == 0) return 0.0f;
  const auto layout = take_layout(in, channels);
  if (!layout) return std::unexpected(layout.error());
  auto decoder = ValueDecoder::open(in, channels);
  if (!decoder) return std::unexpected(decoder.error());
  std::vector<std::int32_t> plane(splats);
  for (std::size_t c = 0; c < channels; ++c) {
    if (auto ok = decoder->next(plane); !ok)
      return fail("", fmt::format("channel {}", c), ok.error().what);
    if (layout->predicted[c] != 0) add_predictions(plane);
    std::ranges::transform(plane, values.begin() + static_cast<std::ptrdiff_t>(c * splats),
                           [](std::int32_t k) { return static_cast<float>(k); });
  }
  restore(*layout, step_scale, values, splats);
  if (math::all_finite(values)) return layout->step;
  const auto bad = std::ranges::find_if_not(values, [](float x) { return std::isfinite(x); });
  return fail("", "",
              fmt::format("splat {} is not finite",
                          static_cast<std::size_t>(bad - values.begin()) % splats));
}

}  // namespace fluxgs::codec
