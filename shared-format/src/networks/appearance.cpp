#include "fluxgs/networks/appearance.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "fluxgs/math/logistic.h"
#include "fluxgs/math/projection.h"
#include "networks/onnx_network.h"

namespace fluxgs::networks {
namespace {

constexpr float kMinDeviation = 1e-6f;
constexpr std::size_t kSh = kShColumns, kEnergy = kEnergyColumns;

float limited(double value) {
  return static_cast<float>(std::clamp<double>(value, -kInputLimit, kInputLimit));
}

glm::dvec3 normalised_position(const Normalisation& n, const glm::vec3& position) {
  return (glm::dvec3(position) - glm::dvec3(n.center)) / double{n.extent};
}

/// f of the paper, section "Energy Aggregation".
glm::dvec3 contracted(const glm::dvec3& p) {
  const double length = glm::length(p);
  return length <= 1 ? p : p * ((2 - 1 / length) / length);
}

/// q and −q are the same rotation; of the two, the one whose first component that is not 0 is
/// positive.
math::Quat<double> unit_quaternion(const glm::quat& q) {
  const auto u = math::normalized(math::Quat<double>{q.w, q.x, q.y, q.z});
  const double components[] = {u.w, u.x, u.y, u.z};
  const double* first = std::ranges::find_if(components, [](double c) { return c != 0; });
  return *first > 0 ? u : math::Quat<double>{-u.w, -u.x, -u.y, -u.z};
}

// Mean and standard deviation, summed in the order of the values.
struct Spread {
  double sum = 0, squares = 0, count = 0;

  void add(double value) {
    sum += value;
    squares += value * value;
    ++count;
  }
  double mean() const { return count == 0 ? 0 : sum / count; }
  double deviation() const {
    const double variance = count == 0 ? 1 : squares / count - mean() * mean();
    return std::max(std::sqrt(std::max(variance, 0.0)), double{kMinDeviation});
  }
};

/// The value below which that part of all values lies; 0 if there are none.
template <class T>
T quantile(std::vector<T>& values, double part) {
  if (values.empty()) return T(0);
  const auto rank = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

Expected<void> check_normalisation(const Normalisation& n, const Place& place) {
  const auto finite = [](float v) { return std::isfinite(v); };
  if (!finite(n.center.x) || !finite(n.center.y) || !finite(n.center.z) ||
      !finite(n.log_scale_mean) || !std::ranges::all_of(n.sh_mean, finite)) {
    return fail(place, "a centre or mean is not finite");
  }
  const auto wide = [](float v) { return std::isfinite(v) && v >= kMinDeviation; };
  if (!wide(n.extent) || !wide(n.log_scale_deviation) ||
      !std::ranges::all_of(n.sh_deviation, wide)) {
    return fail(place, "its extent and deviations must be at least 1e-6");
  }
  return {};
}

Expected<void> check_cloud(const SplatCloud& cloud, std::span<const float> energy, bool has_psi,
                           const std::string& name) {
  if (cloud.sh_degree > 1) {
    return fail(name, "networks",
                fmt::format("the scene is of degree {}; expected 0 or 1", cloud.sh_degree));
  }
  const std::size_t expected = has_psi ? cloud.size() * kEnergy : 0;
  if (energy.size() != expected) {
    return fail(name, "energy", fmt::format("{} values; expected {}", energy.size(), expected));
  }
  return {};
}

Expected<void> make_degree_one(SplatCloud& cloud, const std::string& name) {
  if (cloud.sh_degree == 1) return {};
  try {
    cloud.sh_rest.assign(cloud.size() * 3, glm::vec3(0));
  } catch (const std::exception&) {
    return fail(name, "memory", "out of memory for coefficients of degree 1");
  }
  cloud.sh_degree = 1;
  return {};
}

std::array<float, kSh> coefficients(const SplatCloud& cloud, std::size_t i) {
  std::array<float, kSh> sh;
  for (int k = 0; k < 4; ++k) {
    const auto coefficient = static_cast<std::size_t>(k);
    const glm::vec3& rgb = k == 0 ? cloud.sh_dc[i] : cloud.sh_rest[3 * i + coefficient - 1];
    for (int c = 0; c < 3; ++c) sh[3 * coefficient + static_cast<std::size_t>(c)] = rgb[c];
  }
  return sh;
}

void set_coefficients(SplatCloud& cloud, std::size_t i, std::span<const float, kSh> sh) {
  const auto rgb = [&](std::size_t k) {
    return glm::vec3(sh[3 * k], sh[3 * k + 1], sh[3 * k + 2]);
  };
  cloud.sh_dc[i] = rgb(0);
  for (std::size_t k = 1; k < 4; ++k) cloud.sh_rest[3 * i + k - 1] = rgb(k);
}

/// A network with room for the inputs and outputs of a batch.
class Stage {
 public:
  Stage(OnnxNetwork network, const Signature& signature)
      : network_(std::move(network)), signature_(signature), inputs_(signature.inputs.size()) {}

  const OnnxNetwork& network() const { return network_; }

  /// Evaluates `rows` rows, row(r) being the entries of one; results are in output().
  template <class Row>
  Expected<void> run(std::size_t rows, Row row) {
    for (auto& input : inputs_) input.clear();
    for (std::size_t r = 0; r < rows; ++r) {
      const auto entries = row(r);
      auto next = entries.begin();
      for (std::size_t k = 0; k < inputs_.size(); ++k) {
        const auto end = next + signature_.inputs[k].count;
        inputs_[k].insert(inputs_[k].end(), next, end);
        next = end;
      }
    }
    output_.resize(rows * kSh);
    const std::vector<std::span<const float>> views(inputs_.begin(), inputs_.end());
    return network_.run(rows, views, output_);
  }

  std::span<const float, kSh> output(std::size_t row) const {
    return std::span(output_).subspan(row * kSh).first<kSh>();
  }

 private:
  OnnxNetwork network_;
  const Signature& signature_;
  std::vector<std::vector<float>> inputs_;
  std::vector<float> output_;
};

/// Nothing for an empty model.
Expected<std::optional<Stage>> load_stage(const std::vector<std::byte>& bytes,
                                          const Signature& signature, std::size_t splats,
                                          const Place& place) {
  if (bytes.empty()) return std::optional<Stage>();
  auto network = OnnxNetwork::load(bytes, signature, place);
  if (!network) return std::unexpected(network.error());
  if (auto ok = network->check_rows(splats); !ok) return std::unexpected(ok.error());
  return std::optional<Stage>(std::in_place, std::move(*network), signature);
}

Expected<void> bake_batch(SplatCloud& cloud, std::size_t begin, std::size_t count,
                          std::span<const float> energy, std::optional<Stage>& psi,
                          std::optional<Stage>& phi, const Normalisation& n, const Place& place) {
  if (psi) {
    const auto done = psi->run(count, [&](std::size_t r) {
      return psi_row(n, cloud, begin + r, energy.subspan((begin + r) * kEnergy, kEnergy));
    });
    if (!done) return done;
    for (std::size_t r = 0; r < count; ++r) set_coefficients(cloud, begin + r, psi->output(r));
  }
  if (phi) {
    const auto done = phi->run(count, [&](std::size_t r) {
      return phi_row(n, cloud, begin + r, coefficients(cloud, begin + r));
    });
    if (!done) return done;
    for (std::size_t r = 0; r < count; ++r) {
      auto sh = coefficients(cloud, begin + r);
      for (std::size_t k = 0; k < kSh; ++k) sh[k] += phi->output(r)[k];
      if (!std::ranges::all_of(sh, [](float v) { return std::isfinite(v); })) {
        return fail(place, fmt::format("the colour of splat {} is not finite", begin + r));
      }
      set_coefficients(cloud, begin + r, sh);
    }
  }
  return {};
}

}  // namespace

Normalisation measure_normalisation(const SplatCloud& cloud) {
  Normalisation n;
  std::vector<float> values;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (const glm::vec3& p : cloud.positions) values.push_back(p[axis]);
    n.center[axis] = quantile(values, 0.5);
  }
  std::vector<double> distances;
  distances.reserve(cloud.size());
  for (const glm::vec3& p : cloud.positions) {
    distances.push_back(glm::length(glm::dvec3(p) - glm::dvec3(n.center)));
  }
  n.extent = static_cast<float>(std::max(quantile(distances, 0.9), double{kMinDeviation}));
  Spread scale;
  std::array<Spread, kSh> sh;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) scale.add(cloud.log_scales[i][axis]);
    if (cloud.sh_degree < 1) continue;
    const auto rest = i * static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
    for (std::size_t k = 0; k < kSh; ++k) {
      const glm::vec3& rgb = k < 3 ? cloud.sh_dc[i] : cloud.sh_rest[rest + k / 3 - 1];
      sh[k].add(rgb[static_cast<int>(k % 3)]);
    }
  }
  n.log_scale_mean = static_cast<float>(scale.mean());
  n.log_scale_deviation = static_cast<float>(scale.deviation());
  for (std::size_t k = 0; k < kSh; ++k) {
    n.sh_mean[k] = static_cast<float>(sh[k].mean());
    n.sh_deviation[k] = static_cast<float>(sh[k].deviation());
  }
  return n;
}

const Signature& psi_signature() {
  static const Signature signature{{{"energy", kEnergyColumns}, {"position", 3}},
                                   {"sh", kShColumns}};
  return signature;
}

const Signature& phi_signature() {
  static const Signature signature{
      {{"position", 3}, {"scale", 3}, {"rotation", 4}, {"opacity", 1}, {"sh", kShColumns}},
      {"offset", kShColumns}};
  return signature;
}

std::array<float, kPsiColumns> psi_row(const Normalisation& n, const glm::vec3& position,
                                       std::span<const float> energy) {
  std::array<float, kPsiColumns> row;
  for (std::size_t k = 0; k < kEnergy; ++k) row[k] = limited(energy[k]);
  const glm::dvec3 p = contracted(normalised_position(n, position));
  for (int axis = 0; axis < 3; ++axis)
    row[kEnergy + static_cast<std::size_t>(axis)] = limited(p[axis]);
  return row;
}

std::array<float, kPhiColumns> phi_row(const Normalisation& n, const SplatAttributes& splat,
                                       std::span<const float> sh) {
  std::array<float, kPhiColumns> row;
  auto next = row.begin();
  const auto add = [&](double value) { *next++ = limited(value); };
  const glm::dvec3 p = normalised_position(n, splat.position);
  for (int axis = 0; axis < 3; ++axis) add(p[axis]);
  for (int axis = 0; axis < 3; ++axis) {
    add((double{splat.log_scale[axis]} - double{n.log_scale_mean}) / double{n.log_scale_deviation});
  }
  const auto q = unit_quaternion(splat.rotation);
  for (const double component : {q.w, q.x, q.y, q.z}) add(component);
  add(sigmoid(double{splat.opacity_logit}));
  for (std::size_t k = 0; k < kSh; ++k) {
    add((double{sh[k]} - double{n.sh_mean[k]}) / double{n.sh_deviation[k]});
  }
  return row;
}

std::array<float, kPsiColumns> psi_row(const Normalisation& n, const SplatCloud& cloud,
                                       std::size_t i, std::span<const float> energy) {
  return psi_row(n, cloud.positions[i], energy);
}

std::array<float, kPhiColumns> phi_row(const Normalisation& n, const SplatCloud& cloud,
                                       std::size_t i, std::span<const float> sh) {
  return phi_row(
      n, {cloud.positions[i], cloud.log_scales[i], cloud.rotations[i], cloud.opacity_logits[i]},
      sh);
}

Expected<void> bake_appearance(SplatCloud& cloud, std::span<const float> energy,
                               const AppearanceNetworks& networks, const Normalisation& n,
                               const std::string& name) {
  if (networks.psi.empty() && networks.phi.empty()) return {};
  auto ok = check_normalisation(n, {name, "normalisation"});
  if (ok) ok = check_cloud(cloud, energy, !networks.psi.empty(), name);
  if (!ok) return ok;
  const std::size_t splats = cloud.size();
  auto psi = load_stage(networks.psi, psi_signature(), splats, {name, "network psi"});
  if (!psi) return std::unexpected(psi.error());
  auto phi = load_stage(networks.phi, phi_signature(), splats, {name, "network phi"});
  if (!phi) return std::unexpected(phi.error());
  if (ok = make_degree_one(cloud, name); !ok) return ok;
  const Place place{name, "networks"};
  std::size_t batch = kMaxBatch;
  for (const std::optional<Stage>* stage : {&*psi, &*phi}) {
    if (stage->has_value()) batch = std::min(batch, stage->value().network().batch());
  }
  for (std::size_t begin = 0; begin < splats; begin += batch) {
    const std::size_t count = std::min(batch, splats - begin);
    if (ok = bake_batch(cloud, begin, count, energy, *psi, *phi, n, place); !ok) return ok;
  }
  return {};
}

}  // namespace fluxgs::networks
