#include "trainer/paper/network_rows.h"

#include <algorithm>
#include <cmath>

#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/gltf_frame.h"

namespace fluxgs {
namespace {

// Coefficient k of the SH coefficients takes three entries, as does E_mag and each axis of E_dir.
ShRow sh_signs() {
  ShRow signs;
  for (std::size_t k = 0; k < signs.size(); ++k) signs[k] = k < 3 ? 1 : io::turn_sign(k / 3 - 1);
  return signs;
}
ShRow energy_signs() {
  const glm::vec3 turned = io::turn_position(glm::vec3(1));
  ShRow signs;
  for (std::size_t k = 0; k < signs.size(); ++k)
    signs[k] = k < 3 ? 1 : turned[static_cast<int>(k / 3) - 1];
  return signs;
}
const ShRow kShSigns = sh_signs(), kEnergySigns = energy_signs();

ShRow get(const PlanarFloats& from, int first_row, std::size_t i, const ShRow& signs) {
  ShRow values;
  const float* at = from.row(first_row) + i;
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = signs[k] * at[k * from.stride()];
  return values;
}

void put(const ShRow& values, PlanarFloats& to, int first_row, std::size_t i, const ShRow& signs) {
  float* at = to.row(first_row) + i;
  for (std::size_t k = 0; k < values.size(); ++k) at[k * to.stride()] = signs[k] * values[k];
}

glm::vec3 vector_at(const PlanarFloats& from, int first_row, std::size_t i) {
  return {from.row(first_row)[i], from.row(first_row + 1)[i], from.row(first_row + 2)[i]};
}

template <std::size_t Columns>
void put_finite(const std::array<float, Columns>& values, float* row) {
  // A sum of limited numbers is finite exactly if they all are
  float sum = 0;
  for (const float v : values) sum += v;
  if (std::isfinite(sum))
    std::ranges::copy(values, row);
  else
    std::fill_n(row, Columns, 0.0f);
}

}  // namespace

ShRow turned_sh(const PlanarFloats& from, int first_row, std::size_t i) {
  return get(from, first_row, i, kShSigns);
}
void put_turned_sh(const ShRow& sh, PlanarFloats& to, int first_row, std::size_t i) {
  put(sh, to, first_row, i, kShSigns);
}
ShRow turned_energy(const PlanarFloats& from, std::size_t i) {
  return get(from, 0, i, kEnergySigns);
}
void put_turned_energy(const ShRow& energy, PlanarFloats& to, std::size_t i) {
  put(energy, to, 0, i, kEnergySigns);
}

void put_psi_row(const networks::Normalisation& n, const PlanarFloats& parameters,
                 const PlanarFloats& latents, std::size_t i, float* row) {
  const glm::vec3 position = io::turn_position(vector_at(parameters, row::position, i));
  put_finite(networks::psi_row(n, position, turned_energy(latents, i)), row);
}

void put_phi_row(const networks::Normalisation& n, const PlanarFloats& p, const ShRow& sh,
                 std::size_t i, float* row) {
  const glm::quat rotation(p.row(row::rotation)[i], p.row(row::rotation + 1)[i],
                           p.row(row::rotation + 2)[i], p.row(row::rotation + 3)[i]);
  const networks::SplatAttributes splat{
      .position = io::turn_position(vector_at(p, row::position, i)),
      .log_scale = vector_at(p, row::log_scale, i),
      .rotation = io::turn_to_gltf(canonical_rotation(rotation)),
      .opacity_logit = p.row(row::opacity)[i]};
  put_finite(networks::phi_row(n, splat, sh), row);
}

}  // namespace fluxgs
