// What a training has taken and shown so far, over all the parts that interruptions cut it into.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include <nlohmann/json.hpp>

namespace fluxgs::cli {

struct TrainHistory {
  double seconds = 0, cpu_seconds = 0;
  std::uint64_t rejected_gradients = 0;  ///< that were not finite
  std::map<std::string, double> stages;  ///< seconds by name
  nlohmann::json curves;                 ///< TrainLog::to_json(); null: none yet
};

/// As text, for a checkpoint.
std::string text_of(const TrainHistory& history);

/// The other way round. Nothing of text that is not such, as in checkpoints of before there was
/// any.
TrainHistory history_of(const std::string& text);

/// One history of two parts of a training. Of what is said once, the last word counts.
TrainHistory joined(const TrainHistory& before, const TrainHistory& after);

}  // namespace fluxgs::cli
