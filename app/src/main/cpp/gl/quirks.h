// Known defects and oddities of drivers, each a named boolean with the reason beside it. Code and
// tests that make allowance for one ask for the name, never for the driver.
#pragma once

#include <string>
#include <vector>

#include "gl/capabilities.h"

namespace fluxgs::gl {

struct Quirks {
  /// Blending into RGBA16F rounds every layer towards zero instead of to the nearest half, so
  /// low-opacity layers darken the image: 200 of them cost 24 dB against a driver that rounds.
  /// Mesa's llvmpipe (lp_build_float_to_half in gallivm/lp_bld_conv.c), measured on 22.3.6.
  bool half_float_blending_truncates = false;

  /// The processor plays the GPU (llvmpipe, SwiftShader): what a GPU gains by working on thousands
  /// of splats at once is lost. A thread sorts some 30 times as fast as the compute shaders do.
  bool runs_on_cpu = false;

  /// Timer queries corrupt memory or crash. Drivers of Mali (Filament's OpenGLContext.cpp names r26
  /// and others); no times are taken there.
  bool timer_queries_crash = false;

  /// The GPU blends a tile of the image at a time in a memory of its own, a few MB large: pixels of
  /// 128 bits leave room for small tiles only and are blended at a quarter of the rate. All GPUs of
  /// phones do.
  bool tiles = false;

  /// The order that the compute shaders find is wrong, or they do not link. No driver is known for
  /// it: bench/driver_check.h finds out.
  bool gpu_sort_fails = false;

  /// Fragment shaders compute a splat's projection with less than 32 bits. Some Adreno forget the
  /// precision of members of structs; bench/driver_check.h and the page's first frame find out.
  bool fragment_projection_fails = false;

  /// The names of those that are set.
  std::vector<std::string> names() const;
};

Quirks find_quirks(const Capabilities& capabilities);

}  // namespace fluxgs::gl
