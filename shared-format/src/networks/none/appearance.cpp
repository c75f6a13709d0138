// In place of this folder's parent where there is no onnxruntime: in browsers.
#include "fluxgs/networks/appearance.h"

namespace fluxgs::networks {

Expected<void> bake_appearance(SplatCloud&, std::span<const float>,
                               const AppearanceNetworks& networks, const Normalisation&,
                               const std::string& name) {
  if (networks.psi.empty() && networks.phi.empty()) return {};
  return fail(name, "networks",
              "scenes with networks need onnxruntime, which this viewer does not have: `fluxgs "
              "convert` makes one without networks of them");
}

}  // namespace fluxgs::networks
