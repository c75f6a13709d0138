// Loading of onnxruntime. It is loaded when a scene with networks is opened for the first time, and
// never for other scenes.
//
// The library named by the variable FLUXGS_ONNXRUNTIME, if that is set; otherwise the one that
// tools/setup puts into build/packages/onnxruntime, then that of the system (on Android: of the
// app). Release 1.18 or later; its C interface is stable, so that no header of it is needed.
//
// From release 1.29 on onnxruntime sends usage data over the network unless told otherwise before
// it starts: ORT_DISABLE_TELEMETRY=1 is therefore set in this program's environment, and its
// telemetry is switched off by call as well. tools/setup installs 1.28, which has none built in.
#pragma once

#include <string>

#include "fluxgs/error.h"

namespace fluxgs::networks {

/// The library that was loaded.
struct OnnxRuntimeInfo {
  std::string version;  ///< "1.28.0"
  std::string path;     ///< of the library, as it was found
};

/// Loads the library if it has not been yet. An error says in one line where it was looked for and
/// how to get it; the next call tries again. From any thread, but not while another changes the
/// environment (setenv).
Expected<OnnxRuntimeInfo> onnx_runtime_info();

}  // namespace fluxgs::networks
