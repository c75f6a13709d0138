#include "trainer/core/lanes.h"
#include "trainer/paper/mlp_kernels.h"

namespace fluxgs::FLUXGS_ISA {
namespace {

// A tile of C that stays in registers: 6×4 packs of the 32 registers of AVX-512, 6×2 of the 16 that
// the others have, next to a row of B and one entry of A.
constexpr int kTileRows = 6;
constexpr int kTilePacks = kLanes == 16 ? 4 : 2;
constexpr std::size_t kPack = static_cast<std::size_t>(kLanes);

template <int Rows, int Packs>
void finish(const MlpProductArgs& m, std::size_t r, std::size_t c,
            const Lanes (&sum)[Rows][Packs]) {
  const Lanes zero(0.0f);
  for (std::size_t i = 0; i < Rows; ++i) {
    for (std::size_t j = 0; j < Packs; ++j) {
      const std::size_t column = c + j * kPack, at = (r + i) * m.c_stride + column;
      Lanes value = sum[i][j];
      switch (m.epilogue) {
        case MlpEpilogue::bias:
          value += Lanes::load(m.extra + column);
          break;
        case MlpEpilogue::bias_relu:
          value = max(value + Lanes::load(m.extra + column), zero);
          break;
        case MlpEpilogue::mask:
          value = zero_unless(Lanes::load(m.extra + at) > zero, value);
          break;
        case MlpEpilogue::add:
          value += Lanes::load(m.c + at);
          break;
        case MlpEpilogue::store:
          break;
      }
      value.store(m.c + at);
    }
  }
}

template <int Rows, int Packs>
void tile(const MlpProductArgs& m, std::size_t r, std::size_t c) {
  Lanes sum[Rows][Packs];
  for (auto& row : sum)
    for (Lanes& s : row) s = Lanes(0.0f);
  const float* a = m.a + r * m.a_row;
  const float* b = m.b + c;
  for (std::size_t k = 0; k < m.depth; ++k, a += m.a_step, b += m.b_stride) {
    Lanes packs[Packs];
    for (std::size_t j = 0; j < Packs; ++j) packs[j] = Lanes::load(b + j * kPack);
    for (std::size_t i = 0; i < Rows; ++i) {
      const Lanes entry(a[i * m.a_row]);
      for (std::size_t j = 0; j < Packs; ++j) sum[i][j] = fma(entry, packs[j], sum[i][j]);
    }
  }
  finish<Rows, Packs>(m, r, c, sum);
}

/// The rows that do not fill a tile.
template <int Rows, int Packs>
void last_rows(const MlpProductArgs& m, std::size_t r, std::size_t c) {
  if constexpr (Rows > 0) {
    if (m.rows - r == Rows) return tile<Rows, Packs>(m, r, c);
    last_rows<Rows - 1, Packs>(m, r, c);
  }
}

template <int Packs>
void columns(const MlpProductArgs& m, std::size_t c) {
  std::size_t r = 0;
  for (; r + kTileRows <= m.rows; r += kTileRows) tile<kTileRows, Packs>(m, r, c);
  last_rows<kTileRows - 1, Packs>(m, r, c);
}

}  // namespace

void mlp_product(const MlpProductArgs& m) {
  std::size_t c = 0;
  for (; c + kTilePacks * kPack <= m.columns; c += kTilePacks * kPack) columns<kTilePacks>(m, c);
  if constexpr (kTilePacks == 4) {
    if (m.columns - c >= 2 * kPack) {
      columns<2>(m, c);
      c += 2 * kPack;
    }
    if (c < m.columns) columns<1>(m, c);
  }
}

extern const MlpKernels kMlpKernels;
const MlpKernels kMlpKernels{mlp_product};

}  // namespace fluxgs::FLUXGS_ISA
