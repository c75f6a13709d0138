// A small capture, for the tests that train.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include "run_command.h"
#include "support/temp_folder.h"
#include "tools/capture/capture.h"

namespace fluxgs::test {

/// In a folder of its own, kept for the whole program.
inline const std::filesystem::path& capture_folder() {
  static const TempFolder folder;
  static const bool made = [] {
    capture::CaptureOptions options;
    options.width = 64, options.height = 48, options.train = 12, options.test = 2,
    options.samples = 1;
    return capture::write_capture(folder.path(), options).has_value();
  }();
  if (!made) throw std::runtime_error("cannot make a capture");
  return folder.path();
}

/// Arguments of a training of it, with `more` options.
inline std::string train(const std::filesystem::path& out, const std::string& more) {
  return fmt::format("train {} -o {} --max-splats 2000 {}", quoted(capture_folder()), quoted(out),
                     more);
}

}  // namespace fluxgs::test
