// The shaders of this folder as text, embedded by CMake: foo.comp is shaders::foo_comp.
#pragma once

#include <string_view>

namespace fluxgs::shaders {

extern const std::string_view draw_arguments_comp, gather_comp, layer_frag, mark_frag, project_comp,
    project_frag, project_point_frag, project_point_vert, resolve_frag, screen_vert,
    sort_count_comp, sort_scan_comp, sort_scatter_comp, splat_frag, splat_vert;

}  // namespace fluxgs::shaders
