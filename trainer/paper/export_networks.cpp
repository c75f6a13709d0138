#include "trainer/paper/export_networks.h"

#include "trainer/paper/network_rows.h"

namespace fluxgs {
namespace {

Expected<std::vector<std::byte>> encoded(const std::optional<TrainableMlp>& network,
                                         const networks::Signature& signature) {
  if (!network) return std::vector<std::byte>();
  return networks::encode_onnx(to_mlp(*network), signature);
}

}  // namespace

Expected<CompactNetworks> export_networks(const AppearanceModel& model,
                                          const PlanarFloats& latents) {
  auto psi = encoded(model.psi, networks::psi_signature());
  if (!psi) return fail("", "network psi", psi.error().message());
  auto phi = encoded(model.phi, networks::phi_signature());
  if (!phi) return fail("", "network phi", phi.error().message());
  CompactNetworks out{.models = {std::move(*psi), std::move(*phi)},
                      .normalisation = model.normalisation};
  if (!model.psi) return out;
  out.energy.reserve(latents.size() * networks::kEnergyColumns);
  for (std::size_t i = 0; i < latents.size(); ++i) {
    const ShRow energy = turned_energy(latents, i);
    out.energy.insert(out.energy.end(), energy.begin(), energy.end());
  }
  return out;
}

SplatCloud cloud_for_networks(const AppearanceModel& model, const PlanarFloats& parameters,
                              const PlanarFloats& latents) {
  SplatCloud cloud = to_cloud(parameters, 1);
  for (std::size_t i = 0; !model.psi && i < cloud.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      cloud.sh_dc[i][c] = latents.row(c)[i];
      for (int k = 0; k < 3; ++k)
        cloud.sh_rest[3 * i + static_cast<std::size_t>(k)][c] = latents.row(3 + 3 * k + c)[i];
    }
  }
  canonicalize_rotations(cloud);
  return cloud;
}

}  // namespace fluxgs
