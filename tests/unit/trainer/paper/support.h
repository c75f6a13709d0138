// A small scene with networks, and its colours in float64.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/gltf.h"
#include "tests/support/scenes.h"
#include "trainer/paper/appearance_model.h"

namespace fluxgs::test {

inline constexpr int kSh = networks::kShColumns;

/// Random splats, latents and gradients; networks of random weights (Φ's last layer too).
struct AppearanceScene {
  PlanarFloats parameters, latents, gradient;
  std::vector<std::uint8_t> visible;
  AppearanceModel model;

  AppearanceScene(std::size_t count, bool psi, bool phi) {
    parameters = to_parameters(random_cloud(count, 1, 11, 2.0f), 1);
    gradient = to_parameters(random_cloud(count, 1, 12), 1);
    const PlanarFloats own = to_parameters(random_cloud(count, 1, 13), 1);
    latents = PlanarFloats(kSh, count);
    for (int k = 0; k < kSh; ++k) std::copy_n(own.row(row::sh_dc + k), count, latents.row(k));
    visible.assign(parameters.stride() + 16, 0);
    std::fill_n(visible.begin(), count, std::uint8_t{1});
    model = make_appearance_model(psi, phi, measure_normalisation(parameters), 5);
    Random random(6);
    if (phi) model.phi = make_mlp(kPhiSizes, false, random);
  }

  /// Splats 0, step, 2·step, …
  std::vector<std::uint32_t> every(std::size_t step) const {
    std::vector<std::uint32_t> splats;
    for (std::size_t i = 0; i < parameters.size(); i += step)
      splats.push_back(static_cast<std::uint32_t>(i));
    return splats;
  }
};

/// c of splat i from the definitions: the cloud is turned as a whole, rows and networks are
/// evaluated one by one.
inline std::array<double, kSh> exact_colors(const AppearanceScene& scene, std::size_t i) {
  SplatCloud cloud = to_cloud(scene.parameters.gather({static_cast<std::uint32_t>(i)}), 1);
  canonicalize_rotations(cloud);
  turn_gltf_frame(cloud);
  const auto as_double = [](const auto& row) {
    return std::vector<double>(row.begin(), row.end());
  };
  // Half a turn about z: E_dir along x and y, and the functions −y and −x, change their signs
  constexpr double kEnergySigns[4] = {1, -1, -1, 1}, kShSigns[4] = {1, -1, 1, -1};
  std::vector<double> base;
  std::vector<float> latents;
  for (int k = 0; k < kSh; ++k) {
    const double sign = scene.model.psi ? kEnergySigns[k / 3] : kShSigns[k / 3];
    base.push_back(sign * double{scene.latents.row(k)[i]});
    latents.push_back(static_cast<float>(base.back()));
  }
  const networks::Normalisation& n = scene.model.normalisation;
  if (scene.model.psi)
    base = networks::evaluate(to_mlp(*scene.model.psi),
                              as_double(networks::psi_row(n, cloud, 0, latents)));
  if (scene.model.phi) {
    const std::vector<float> rounded(base.begin(), base.end());
    auto row = as_double(networks::phi_row(n, cloud, 0, rounded));
    // Without the rounding to float32, which would disturb differences
    for (std::size_t k = 0; k < kSh; ++k)
      row[11 + k] = (base[k] - double{n.sh_mean[k]}) / double{n.sh_deviation[k]};
    const auto offset = networks::evaluate(to_mlp(*scene.model.phi), row);
    for (std::size_t k = 0; k < kSh; ++k) base[k] += offset[k];
  }
  std::array<double, kSh> colors;
  for (std::size_t k = 0; k < kSh; ++k) colors[k] = kShSigns[k / 3] * base[k];
  return colors;
}

}  // namespace fluxgs::test
