// Reads results of the app's benchmark (BenchmarkResult.kt).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "fluxgs/error.h"

namespace fluxgs::cli {

/// One size of image, kind of views and sorter. Times are medians over the frames, > 0.
struct PhoneRow {
  int width = 0, height = 0;
  std::string views, sorter;
  double in_flight_ms = 0;  ///< draw_ms in results of older apps, which lack it
  double draw_ms = 0, sort_to_display_ms = 0, pipelined_ms = 0;

  std::string name() const;  ///< the same for the same measurement in another run
};

struct PhoneResult {
  std::string device;        ///< maker, model, processor, Android's version
  std::string driver;        ///< of OpenGL ES
  std::string driver_check;  ///< whether it draws right, in words; empty: is not said
  std::string app;           ///< its version
  std::string scene;         ///< file name
  std::uint64_t splats = 0, bytes = 0;
  std::uint64_t warmup = 0, frames = 0;          ///< of each row
  std::string blended_in;                        ///< "RGBA32F", "RGBA16F"; empty: is not said
  bool beside_another = false;                   ///< in split screen
  int heat_before = 0, heat_after = 0;           ///< thermal status of Android, 0 (none)…6
  std::string stopped;                           ///< why before its end; empty: it is whole
  std::map<std::string, std::string> self_test;  ///< "error": it failed; empty: none was made
  std::vector<PhoneRow> rows;
};

/// Errors name the file and the field that is missing or of the wrong kind.
Expected<PhoneResult> phone_result(const nlohmann::json& value, const std::string& file);

}  // namespace fluxgs::cli
