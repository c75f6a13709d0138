// The inner loops of the CPU rasteriser: plain structs and function pointers, one table for each
// instruction set. Everything here works on memory that the caller owns; nothing allocates.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fluxgs/math/projection.h"
#include "trainer/core/isa.h"
#include "trainer/raster/score.h"

namespace fluxgs {

inline constexpr int kTileSize = 16;  ///< px
inline constexpr int kBlockSize = 4;  ///< px; a tile has 4×4 blocks of 4×4 px
inline constexpr int kTilePixels = kTileSize * kTileSize;

/// The footprint's factor is stored times √(½·log₂e), so that α = 2^(log2_opacity − u² − v²):
/// one exponential to base 2 and no further product per pixel.
inline constexpr float kFactorScale = 0.8493218002880191f;

/// A splat on the image, one cache line.
struct alignas(64) ProjectedSplat {
  float x, y;        ///< centre, px
  float xx, xy, yy;  ///< triangular factor of the conic × kFactorScale
  float log2_opacity;
  float r, g, b;                  ///< colour ≥ 0
  float depth;                    ///< camera z
  float half_width, half_height;  ///< px, the box outside of which α < α_min
  float opacity;                  ///< of the splat, before a ScreenFilter compensates it
  float unused[3];
};

/// The image model's constants in the form the kernels use.
struct RasterConstants {
  float alpha_max, log2_alpha_max, alpha_min, log2_alpha_min, transmittance_min;
  float background[3];
};

struct ProjectArgs {
  const float* parameters;  ///< rows as in trainer/model/parameters.h
  std::size_t stride;       ///< floats from row to row
  std::size_t size;         ///< splats
  int sh_degree;            ///< degree to evaluate
  math::View<float> view;
  RasterConstants constants;
  ProjectedSplat* out;    ///< [size], written where visible
  std::uint8_t* visible;  ///< [padded size]: 1 where the splat can touch the image
};

/// One splat in one tile. Bit 4·row + column of `blocks` is set where the ellipse may reach the
/// block; the forward pass clears those that are finished when the splat's turn comes. `slot` is
/// where the backward pass leaves this pair's gradient.
struct TileEntry {
  std::uint32_t splat, slot, blocks;
};

/// A splat that reaches a tile, before the tiles' entries are placed.
struct TileBin {
  std::uint32_t splat, tile, blocks;
};

/// The gradient of one splat–tile pair: moments (see math::FootprintMoments, in units of the scaled
/// factor), Σh, the colour's gradient, and padding.
struct alignas(16) PairGradient {
  float u, v, uu, uv, vv, h, r, g, b, unused[3];
};

struct TileArgs {
  const ProjectedSplat* splats;
  TileEntry* entries;
  std::uint32_t count;
  int x0, y0;         ///< the tile's corner, px
  int width, height;  ///< the image's size
  std::size_t pitch;  ///< floats from row to row of a plane
  RasterConstants constants;
  float* color;                         ///< 3 planes of pitch·height, including the background
  float* transmittance;                 ///< 1 plane: the share of the background at each pixel
  const float* color_gradient;          ///< 3 planes (backward only)
  const float* transmittance_gradient;  ///< 1 plane, or null (backward only)
  PairGradient* gradients;              ///< indexed by TileEntry::slot (backward only)
  std::uint64_t* pairs;  ///< if not null, the number of contributing splat–pixel pairs is added
};

/// The scores of one splat–tile pair: Σ w·map of two maps, Σ α·T, and how many pixels it reached.
struct alignas(16) PairScore {
  float first, second, contribution, pixels;
};

struct ScoreArgs {
  TileArgs tile;      ///< images and gradients are not used
  const float* maps;  ///< 2 planes of pitch·height, or 3
  bool masked;        ///< the third plane is 0 where a pixel adds nothing
  ScoreWeight weight;
  PairScore* scores;  ///< indexed by TileEntry::slot
};

/// The removal of one splat, as one tile sees it: the change of the tile's squared error, and how
/// many pixels the splat reached.
struct PairRemoval {
  float change, pixels;
};

struct RemovalArgs {
  TileArgs tile;        ///< with the color of the forward pass; gradients are not used
  const float* target;  ///< 3 planes of pitch·height, or 4
  bool masked;          ///< the fourth plane is 0 where a pixel adds nothing
  PairRemoval* costs;   ///< indexed by TileEntry::slot
};

struct GradientArgs {
  const float* parameters;
  std::size_t stride, size;
  int sh_degree;
  math::View<float> view;
  const ProjectedSplat* splats;
  const PairGradient* sums;  ///< [size]: over the pairs of each visible splat
  float* gradients;        ///< rows as the parameters; written for every pack with a visible splat
  float* center_gradient;  ///< one row: |∂L/∂centre| in normalised device coordinates
  std::uint8_t* visible;   ///< cleared where a gradient is not finite
};

struct RasterKernels {
  /// Projects splats [begin, end); begin is a multiple of 16.
  void (*project)(const ProjectArgs&, std::size_t begin, std::size_t end);
  /// Lists the tiles that the ellipse {α ≥ α_min} of splats[index] reaches, in row-major order,
  /// with the blocks inside each. `out` must hold every tile of the splat's box and one more.
  /// Returns how many.
  std::uint32_t (*bin)(const ProjectedSplat* splats, std::uint32_t index, const RasterConstants&,
                       int tiles_x, int tiles_y, TileBin* out);
  /// Renders a tile. Returns how many entries were used before every pixel was finished.
  std::uint32_t (*forward)(const TileArgs&);
  /// Replays the first `count` entries of a tile and writes their pairs' gradients.
  void (*backward)(const TileArgs&);
  /// Replays the first `count` entries of a tile and writes their pairs' scores.
  void (*score)(const ScoreArgs&);
  /// Replays the first `count` entries of a tile and writes what removing each splat would cost.
  void (*removal)(const RemovalArgs&);
  /// Chain rule from the summed pair gradients to the parameters, for splats [begin, end).
  /// Returns how many visible splats had a gradient that is not finite (they become invisible).
  std::uint32_t (*gradient)(const GradientArgs&, std::size_t begin, std::size_t end);
};

const RasterKernels& raster_kernels(Isa isa);

}  // namespace fluxgs
