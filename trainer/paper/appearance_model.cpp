#include "trainer/paper/appearance_model.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fluxgs/io/gltf.h"

namespace fluxgs {
namespace {

constexpr std::size_t kNormalisationFloats = 6 + 2 * networks::kShColumns;

std::vector<float> to_floats(const networks::Normalisation& n) {
  std::vector<float> out{n.center.x, n.center.y,       n.center.z,
                         n.extent,   n.log_scale_mean, n.log_scale_deviation};
  out.insert(out.end(), n.sh_mean.begin(), n.sh_mean.end());
  out.insert(out.end(), n.sh_deviation.begin(), n.sh_deviation.end());
  return out;
}

networks::Normalisation normalisation_from(std::span<const float, kNormalisationFloats> f) {
  networks::Normalisation n{.center = {f[0], f[1], f[2]},
                            .extent = f[3],
                            .log_scale_mean = f[4],
                            .log_scale_deviation = f[5]};
  std::copy_n(f.begin() + 6, networks::kShColumns, n.sh_mean.begin());
  std::copy_n(f.begin() + 6 + networks::kShColumns, networks::kShColumns, n.sh_deviation.begin());
  return n;
}

}  // namespace

double NetworkRates::psi_at(int step) const {
  const auto passed = std::ranges::count_if(psi_decay_at, [&](int at) { return at <= step; });
  const double warm = psi_warmup > 0 ? std::min(1.0, (step + 1.0) / psi_warmup) : 1.0;
  return psi * warm * std::pow(psi_decay, static_cast<double>(passed));
}

AppearanceModel make_appearance_model(bool psi, bool phi,
                                      const networks::Normalisation& normalisation,
                                      std::uint64_t seed) {
  AppearanceModel model{.normalisation = normalisation};
  Random random(seed);
  if (psi) model.psi = make_mlp(kPsiSizes, false, random);
  if (phi) model.phi = make_mlp(kPhiSizes, true, random);
  return model;
}

networks::Normalisation measure_normalisation(const PlanarFloats& parameters) {
  SplatCloud cloud = to_cloud(parameters, 1);
  drop_non_finite(cloud);
  turn_gltf_frame(cloud);
  return networks::measure_normalisation(cloud);
}

std::vector<float> to_floats(const AppearanceModel& model) {
  std::vector<float> out = to_floats(model.normalisation);
  for (const auto* network : {&model.psi, &model.phi}) {
    if (!network->has_value()) continue;
    const std::vector<float> own = to_floats(network->value());
    out.insert(out.end(), own.begin(), own.end());
  }
  return out;
}

std::size_t appearance_floats(bool psi, bool phi) {
  return kNormalisationFloats + (psi ? float_count(kPsiSizes) : 0) +
         (phi ? float_count(kPhiSizes) : 0);
}

Expected<AppearanceModel> model_from_floats(bool psi, bool phi, std::span<const float> floats) {
  const std::size_t of_psi = psi ? float_count(kPsiSizes) : 0;
  const std::size_t of_phi = phi ? float_count(kPhiSizes) : 0;
  const std::size_t expected = kNormalisationFloats + of_psi + of_phi;
  if (floats.size() != expected)
    return fail("", "networks", fmt::format("{} values, expected {}", floats.size(), expected));
  const auto constants = floats.first<kNormalisationFloats>();
  if (!std::ranges::all_of(constants, [](float v) { return std::isfinite(v); }))
    return fail("", "networks", "the normalisation is not finite");
  AppearanceModel model{.normalisation = normalisation_from(constants)};
  if (psi) {
    auto network = mlp_from_floats(kPsiSizes, floats.subspan(kNormalisationFloats, of_psi));
    if (!network) return std::unexpected(network.error());
    model.psi = std::move(*network);
  }
  if (phi) {
    auto network = mlp_from_floats(kPhiSizes, floats.last(of_phi));
    if (!network) return std::unexpected(network.error());
    model.phi = std::move(*network);
  }
  return model;
}

}  // namespace fluxgs
