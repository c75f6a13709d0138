// Drivers' messages about shaders, with the files and lines that people know.
#pragma once

#include <string>
#include <string_view>

namespace fluxgs::gl {

/// The log of a driver that compiled `text`, with the "SOURCE:LINE" at the start of every message
/// (Mesa: "0:12(5): error: …"; ANGLE, Adreno: "ERROR: 0:12: …"; Mali: "0:12: L0001: …"; NVIDIA:
/// "0(12) : error …") as "FILE:LINE". Lines below 1000 are those of the file `name`; to which file
/// others belong is noted down in the text (shaders/embed.cmake). Where it is not, the message
/// stays as it is.
std::string name_lines(std::string_view log, std::string_view name, std::string_view text);

}  // namespace fluxgs::gl
