// The screen filter of a scene in glTF: `extras.screenFilter` of KHR_gaussian_splatting's object,
// which other programs skip. It has a member for each of ScreenFilter; without it the filter is the
// classic one.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "fluxgs/screen_filter.h"

namespace fluxgs::io {

inline constexpr double kMaxDilation = 100;  ///< px² that a file may ask for

/// The filter of the first splat primitive that names one; nothing if none does. Values out of
/// range are replaced by the default's, and other primitives' different filters ignored, with a
/// warning.
std::optional<ScreenFilter> find_screen_filter(const nlohmann::json& document,
                                               std::vector<std::string>& warnings);

/// The extras of a primitive's extension object; null for the classic filter.
nlohmann::json screen_filter_extras(const ScreenFilter& filter);

}  // namespace fluxgs::io
