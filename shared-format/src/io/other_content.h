// Kinds of files that are no scenes, for the message about them.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace fluxgs::io {

/// A clause about content that is often met under a scene's name: "is a web page, not what was to
/// be downloaded", "is a PNG image". Empty for what is not known.
std::string describe_other_content(std::span<const std::byte> bytes);

}  // namespace fluxgs::io
