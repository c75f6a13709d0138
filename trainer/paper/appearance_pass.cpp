#include "trainer/paper/appearance_pass.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "trainer/paper/network_rows.h"

namespace fluxgs {
namespace {

constexpr std::size_t kSh = networks::kShColumns;
// Where the columns that have a gradient begin in the rows of Ψ and Φ
constexpr int kPsiEnergy = 0, kPhiSh = networks::kPhiColumns - networks::kShColumns;
// Splats whose gradients of weights are added up one after the other: few enough to occupy many
// threads, enough that the sums of a group (60 KB) are cheap to add.
constexpr std::size_t kGroup = 10 * kMlpPiece;

/// Matrices of a piece's rows that the calling thread keeps; in glTF's frame.
struct PieceRows {
  static PlanarFloats matrix() { return {static_cast<int>(kMlpPiece), kSh}; }
  PlanarFloats base = matrix(), offset = matrix();  // c′ and Φ, or ∂L/∂c′ and ∂L/∂(inputs)
};
PieceRows& piece_rows() {
  thread_local PieceRows rows;
  return rows;
}

ShRow sh_row(const PlanarFloats& matrix, std::size_t r) {
  ShRow sh;
  std::copy_n(matrix.row(r), kSh, sh.begin());
  return sh;
}

/// shade() for at most kMlpPiece splats, which take the rows of the batches from `at` on.
void shade_piece(const AppearanceModel& model, const PlanarFloats& parameters,
                 const PlanarFloats& latents, std::span<const std::uint32_t> splats, MlpBatch& psi,
                 MlpBatch& phi, std::size_t at, const MlpKernels& kernels, PlanarFloats& colors) {
  auto& [base, offset] = piece_rows();
  const std::size_t count = splats.size();
  if (model.psi) {
    for (std::size_t r = 0; r < count; ++r)
      put_psi_row(model.normalisation, parameters, latents, splats[r], psi.values[0].row(at + r));
    forward(*model.psi, psi, at, at + count, base, kernels);
  } else {
    for (std::size_t r = 0; r < count; ++r)
      std::ranges::copy(turned_sh(latents, 0, splats[r]), base.row(r));
  }
  if (model.phi) {
    for (std::size_t r = 0; r < count; ++r)
      put_phi_row(model.normalisation, parameters, sh_row(base, r), splats[r],
                  phi.values[0].row(at + r));
    forward(*model.phi, phi, at, at + count, offset, kernels);
  }
  for (std::size_t r = 0; r < count; ++r) {
    ShRow sh = sh_row(base, r);
    for (std::size_t k = 0; model.phi && k < kSh; ++k) sh[k] += offset.row(r)[k];
    put_turned_sh(sh, colors, row::sh_dc, splats[r]);
  }
}

/// The gradient of a splat's c; zero, and counted, where it is not finite.
ShRow finite_gradient(const ShRow& gradient, std::atomic<std::uint64_t>& rejected) {
  if (std::ranges::all_of(gradient, [](float g) { return std::isfinite(g); })) return gradient;
  ++rejected;
  return {};
}

void clear(MlpMatrices& matrices) {
  for (PlanarFloats& m : matrices)
    std::fill_n(m.data(), static_cast<std::size_t>(m.rows()) * m.stride(), 0.0f);
}

}  // namespace

AppearancePass::AppearancePass(const Threads& threads, Isa isa)
    : threads_(threads), kernels_(mlp_kernels(isa)), adam_(adam_kernels(isa)) {}

void AppearancePass::shade(const AppearanceModel& model, const PlanarFloats& parameters,
                           const PlanarFloats& latents, std::span<const std::uint32_t> splats,
                           PlanarFloats& colors) {
  splats_.assign(splats.begin(), splats.end());
  if (model.psi) reserve(psi_.batch, *model.psi, splats.size());
  if (model.phi) reserve(phi_.batch, *model.phi, splats.size());
  threads_.for_pieces(splats.size(), kMlpPiece, [&](std::size_t begin, std::size_t end) {
    shade_piece(model, parameters, latents, splats.subspan(begin, end - begin), psi_.batch,
                phi_.batch, begin, kernels_, colors);
  });
}

void AppearancePass::prepare(const std::optional<TrainableMlp>& network, int first_input,
                             Room& room) const {
  if (!network) return;
  transpose(*network, first_input, static_cast<int>(kSh), room.transposed);
  const std::size_t groups = (splats_.size() + kGroup - 1) / kGroup;
  while (room.groups.size() < groups) room.groups.push_back(make_matrices(network->sizes));
  if (room.gradient.empty()) room.gradient = make_matrices(network->sizes);
}

void AppearancePass::backpropagate_piece(const AppearanceModel& model, const PlanarFloats& gradient,
                                         const std::vector<std::uint8_t>& visible,
                                         std::size_t begin, std::size_t end,
                                         PlanarFloats& latent_gradient) {
  auto& [base, inputs] = piece_rows();
  const std::size_t group = begin / kGroup;
  for (std::size_t r = begin; r < end; ++r) {
    const std::uint32_t splat = splats_[r];
    const ShRow own = visible[splat]
                          ? finite_gradient(turned_sh(gradient, row::sh_dc, splat), rejected_)
                          : ShRow{};
    std::ranges::copy(own, base.row(r - begin));
  }
  if (model.phi) {
    backward(*model.phi, phi_.transposed, phi_.batch, begin, end, base, phi_.groups[group], inputs,
             kernels_);
    for (std::size_t r = begin; r < end; ++r) {
      const float* entries = phi_.batch.values[0].row(r) + kPhiSh;
      for (std::size_t k = 0; k < kSh; ++k)
        if (moves(entries[k]))
          base.row(r - begin)[k] += inputs.row(r - begin)[k] / model.normalisation.sh_deviation[k];
    }
  }
  if (model.psi)
    backward(*model.psi, psi_.transposed, psi_.batch, begin, end, base, psi_.groups[group], inputs,
             kernels_);
  for (std::size_t r = begin; r < end; ++r) {
    ShRow own = sh_row(model.psi ? inputs : base, r - begin);
    if (!model.psi) {
      put_turned_sh(finite_gradient(own, rejected_), latent_gradient, 0, splats_[r]);
      continue;
    }
    const float* entries = psi_.batch.values[0].row(r) + kPsiEnergy;
    for (std::size_t k = 0; k < kSh; ++k)
      if (!moves(entries[k])) own[k] = 0;
    put_turned_energy(finite_gradient(own, rejected_), latent_gradient, splats_[r]);
  }
}

void AppearancePass::add_groups(const std::optional<TrainableMlp>& network, Room& room) const {
  if (!network) return;
  const std::size_t groups = (splats_.size() + kGroup - 1) / kGroup;
  clear(room.gradient);
  for (std::size_t l = 0; l < room.gradient.size(); ++l) {
    float* sum = room.gradient[l].data();
    const auto rows = static_cast<std::size_t>(room.gradient[l].rows());
    threads_.for_pieces(rows * room.gradient[l].stride(), 2048,
                        [&](std::size_t begin, std::size_t end) {
                          for (std::size_t g = 0; g < groups; ++g) {
                            const float* own = room.groups[g][l].data();
                            for (std::size_t i = begin; i < end; ++i) sum[i] += own[i];
                          }
                        });
  }
}

void AppearancePass::backpropagate(const AppearanceModel& model, const PlanarFloats& gradient,
                                   const std::vector<std::uint8_t>& visible,
                                   PlanarFloats& latent_gradient) {
  prepare(model.psi, kPsiEnergy, psi_);
  prepare(model.phi, kPhiSh, phi_);
  threads_.for_pieces(splats_.size(), kGroup, [&](std::size_t begin, std::size_t end) {
    if (model.psi) clear(psi_.groups[begin / kGroup]);
    if (model.phi) clear(phi_.groups[begin / kGroup]);
    for (std::size_t piece = begin; piece < end; piece += kMlpPiece)
      backpropagate_piece(model, gradient, visible, piece, std::min(end, piece + kMlpPiece),
                          latent_gradient);
  });
  add_groups(model.psi, psi_);
  add_groups(model.phi, phi_);
}

void AppearancePass::step(AppearanceModel& model, const NetworkRates& rates,
                          const AdamConstants& constants) {
  if (model.psi)
    rejected_ +=
        adam_step(*model.psi, psi_.gradient, rates.psi_at(model.psi->steps), constants, adam_);
  if (model.phi) rejected_ += adam_step(*model.phi, phi_.gradient, rates.phi, constants, adam_);
}

void bake(const AppearanceModel& model, const PlanarFloats& parameters, const PlanarFloats& latents,
          const Threads& threads, PlanarFloats& colors, Isa isa) {
  threads.for_pieces(parameters.size(), 16 * kMlpPiece, [&](std::size_t begin, std::size_t end) {
    MlpBatch psi, phi;
    if (model.psi) reserve(psi, *model.psi, kMlpPiece);
    if (model.phi) reserve(phi, *model.phi, kMlpPiece);
    std::array<std::uint32_t, kMlpPiece> splats;
    for (; begin < end; begin += kMlpPiece) {
      const std::size_t count = std::min(kMlpPiece, end - begin);
      std::iota(splats.begin(), splats.end(), static_cast<std::uint32_t>(begin));
      shade_piece(model, parameters, latents, std::span(splats).first(count), psi, phi, 0,
                  mlp_kernels(isa), colors);
    }
  });
}

}  // namespace fluxgs
