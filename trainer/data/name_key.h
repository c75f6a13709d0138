// Names of images and masks, compared as people read them.
#pragma once

#include <string>
#include <string_view>

namespace fluxgs {

/// A key that two names share if they differ only in case (É, é), in how Unicode composes their
/// letters (é as one character, or e and an accent, which macOS writes), or in the direction of
/// slashes. Names that are not UTF-8 are compared byte by byte, A to Z in any case.
/// Source: Unicode 15, chapters 3.11 (normalization form C) and 3.13 (default case folding).
std::string name_key(std::string_view name);

}  // namespace fluxgs
