// Finding the properties of splats in an element of a PLY file.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "fluxgs/error.h"
#include "io/ply/ply_header.h"

namespace fluxgs::io {

bool has_ply_property(const PlyElement& element, std::string_view property);

/// The degree, 0…highest, that the number of properties f_rest_* tells: 0, 9, 24, 45 or 72.
Expected<int> ply_sh_degree(const PlyElement& element, int highest, const std::string& name);

/// The index of a property among those of its element; an error if it is missing or there twice.
/// `format` says in errors whose properties are expected.
Expected<std::size_t> find_ply_property(const PlyElement& element, std::string_view property,
                                        std::string_view format, const std::string& name);

}  // namespace fluxgs::io
