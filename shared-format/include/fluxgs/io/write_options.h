// Wishes for the writing of a scene, and the way to hear from a writer.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "fluxgs/io/initial_view.h"

namespace fluxgs {

/// Options of the writers of scene_formats(). Each looks at those that concern its format.
struct WriteOptions {
  int spz_version = 3;  ///< 3 (gzip, read everywhere) or 4 (zstd, smaller)
  /// The start view, which .glb, .ply and .compressed.ply can hold.
  std::optional<InitialView> start = {};

  /// Called now and then with the part of the work that is done, 0…1, by writers that take long.
  std::function<void(double)> progress = {};
  /// Called with what a person should know of the file written, a sentence without its name.
  std::function<void(const std::string&)> warn = {};
};

}  // namespace fluxgs
