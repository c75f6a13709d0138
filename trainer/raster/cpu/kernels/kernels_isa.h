// Declarations of one instruction set's kernels; see ../kernels.h for what they do.
#pragma once

#include "trainer/raster/cpu/raster_kernels.h"

namespace fluxgs::FLUXGS_ISA {

void project(const ProjectArgs& args, std::size_t begin, std::size_t end);
std::uint32_t bin(const ProjectedSplat* splats, std::uint32_t index,
                  const RasterConstants& constants, int tiles_x, int tiles_y, TileBin* out);
std::uint32_t forward(const TileArgs& args);
void backward(const TileArgs& args);
void score(const ScoreArgs& args);
void removal(const RemovalArgs& args);
std::uint32_t gradient(const GradientArgs& args, std::size_t begin, std::size_t end);

}  // namespace fluxgs::FLUXGS_ISA
