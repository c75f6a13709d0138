// The indices of a batch of quads.
#pragma once

#include <cstdint>
#include <vector>

#include "gl/buffer.h"

namespace fluxgs::render {

constexpr int kIndicesOfAQuad = 6;
constexpr std::size_t kIndexBytesOfAQuad = kIndicesOfAQuad * sizeof(std::uint16_t);

/// Two triangles per quad of corners 4q … 4q + 3 (bit 0: right, bit 1: bottom), as 16-bit indices.
Expected<gl::Buffer> create_quad_indices(gl::Api& api, int quads);

}  // namespace fluxgs::render
