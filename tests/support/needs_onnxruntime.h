// For tests that run networks.
#pragma once

#include <gtest/gtest.h>

#include "fluxgs/networks/onnx_runtime.h"

/// Skips the test, and says why, where onnxruntime could not be installed.
#define FLUXGS_NEEDS_ONNXRUNTIME()                                                  \
  if (const auto info = fluxgs::networks::onnx_runtime_info(); !info.has_value()) { \
    GTEST_SKIP() << info.error().message();                                         \
  }
