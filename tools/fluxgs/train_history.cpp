#include "tools/fluxgs/train_history.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;

json joined(const json& before, const json& after) {
  if (before.is_null()) return after;
  json curves = before;
  for (const auto& [key, value] : after.items()) {
    json& all = curves[key];
    if (all.is_array() && value.is_array())
      all.insert(all.end(), value.begin(), value.end());
    else if (!value.is_null())
      all = value;
  }
  return curves;
}

}  // namespace

std::string text_of(const TrainHistory& history) {
  return json{{"seconds", history.seconds},
              {"cpu_seconds", history.cpu_seconds},
              {"rejected_gradients", history.rejected_gradients},
              {"stages", history.stages},
              {"curves", history.curves}}
      .dump();
}

TrainHistory history_of(const std::string& text) {
  try {
    const json all = json::parse(text);
    TrainHistory history;
    all.at("seconds").get_to(history.seconds);
    all.at("cpu_seconds").get_to(history.cpu_seconds);
    all.at("rejected_gradients").get_to(history.rejected_gradients);
    all.at("stages").get_to(history.stages);
    history.curves = all.at("curves");
    const bool known = history.curves.is_object() || history.curves.is_null();
    return known ? history : TrainHistory{};
  } catch (const json::exception&) {
    return {};
  }
}

TrainHistory joined(const TrainHistory& before, const TrainHistory& after) {
  TrainHistory all = after;
  all.seconds += before.seconds;
  all.cpu_seconds += before.cpu_seconds;
  all.rejected_gradients += before.rejected_gradients;
  for (const auto& [name, seconds] : before.stages) all.stages[name] += seconds;
  all.curves = joined(before.curves, after.curves);
  return all;
}

}  // namespace fluxgs::cli
