// The state of a session as JSON text, for shells that are not written in C++.
#pragma once

#include <string>

#include "viewer/session.h"

namespace fluxgs::viewer {

/// {"loading": {"phase": "idle" | "reading" | "decoding" | "ready" | "failed" | "cancelled",
/// "read", "bytes", "error", "problem", "format", "splats", "shDegree", "memory"}, "hasScene",
/// "drawn", "coarse", "shown", "flipped", "motion": "" | "drift" | "path" | "walk", "error",
/// "contexts", "dropped", "firstFrameMs", "stats": {"fps", "frameMs", "sortMs", "drawn", "shown",
/// "splats", "width", "height", "scale"}}. format to memory are 0 or "" until the file is read.
std::string to_json(const SessionState& state);

/// "loading" of it.
std::string to_json(const LoadState& state);

/// {"running", "done", "all", "rows": […], "stopped", "error"}; only a benchmark has rows.
std::string to_json(const RunState& state);

}  // namespace fluxgs::viewer
