#include "tools/fluxgs/cameras/view_script.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"

namespace fluxgs::cli {
namespace {

using nlohmann::json;
using Kind = viewer::WindowEvent::Kind;

constexpr double kLargest = 1e5;
constexpr int kMaxWindowSide = 16384, kMaxStep = 1'000'000;

std::optional<glm::dvec2> pair_of(const json& entry, const char* key) {
  const auto it = entry.find(key);
  if (it == entry.end() || !it->is_array() || it->size() != 2 || !(*it)[0].is_number() ||
      !(*it)[1].is_number())
    return std::nullopt;
  const glm::dvec2 v((*it)[0], (*it)[1]);
  if (!(std::max(std::abs(v.x), std::abs(v.y)) <= kLargest)) return std::nullopt;
  return v;
}

std::optional<bool> flag_of(const json& entry, const char* key) {
  const auto it = entry.find(key);
  if (it == entry.end() || !it->is_boolean()) return std::nullopt;
  return it->get<bool>();
}

std::string text_of(const json& entry, const char* key) {
  const auto it = entry.find(key);
  return it != entry.end() && it->is_string() ? it->get<std::string>() : std::string();
}

std::optional<viewer::WindowEvent> button_of(const json& entry) {
  constexpr std::array names = {"left", "middle", "right"};
  const auto it = std::ranges::find(names, text_of(entry, "button"));
  const auto at = pair_of(entry, "at");
  const auto down = flag_of(entry, "down");
  if (it == names.end() || !at || !down) return std::nullopt;
  return viewer::WindowEvent{.kind = Kind::button,
                             .position = *at,
                             .button = static_cast<viewer::PointerButton>(it - names.begin()),
                             .down = *down};
}

std::optional<viewer::WindowEvent> key_of(const json& entry) {
  const std::string name = text_of(entry, "key");
  const auto down = flag_of(entry, "down");
  if (!down || (name != "Escape" && name.size() != 1)) return std::nullopt;
  return viewer::WindowEvent{
      .kind = Kind::key, .down = *down, .key = name == "Escape" ? viewer::kEscape : name[0]};
}

std::optional<viewer::WindowEvent> event_of(const json& entry) {
  if (const auto to = pair_of(entry, "move"))
    return viewer::WindowEvent{.kind = Kind::pointer_moved, .position = *to};
  if (entry.contains("button")) return button_of(entry);
  if (entry.contains("key")) return key_of(entry);
  if (const std::string text = text_of(entry, "type"); text.size() == 1)
    return viewer::WindowEvent{.kind = Kind::text, .key = text[0]};
  const auto scroll = entry.find("scroll");
  const auto at = pair_of(entry, "at");
  if (scroll == entry.end() || !scroll->is_number() || !at) return std::nullopt;
  const double amount = scroll->get<double>();
  if (!(std::abs(amount) <= 1000)) return std::nullopt;
  return viewer::WindowEvent{.kind = Kind::scrolled, .position = *at, .amount = amount};
}

std::optional<ScriptedEvent> scripted_event(const json& entry) {
  if (!entry.is_object()) return std::nullopt;
  const auto step = entry.find("step");
  if (step == entry.end() || !step->is_number_integer() || *step < 0 || *step > kMaxStep)
    return std::nullopt;
  ScriptedEvent scripted;
  scripted.step = step->get<int>();
  if (const auto size = pair_of(entry, "resize")) {
    if (!(std::min(size->x, size->y) >= 1 && std::max(size->x, size->y) <= kMaxWindowSide))
      return std::nullopt;
    scripted.resize = {static_cast<int>(size->x), static_cast<int>(size->y)};
    return scripted;
  }
  if (flag_of(entry, "lose_context") == true) {
    scripted.lose_context = true;
    return scripted;
  }
  const auto event = event_of(entry);
  if (!event) return std::nullopt;
  scripted.event = *event;
  return scripted;
}

}  // namespace

Expected<std::vector<ScriptedEvent>> read_view_script(const std::string& path) {
  const auto bytes = read_file(path, 64u << 20);
  if (!bytes) return std::unexpected(bytes.error());
  const char* text = reinterpret_cast<const char*>(bytes->data());
  const json list = json::parse(text, text + bytes->size(), nullptr, false);
  if (!list.is_array()) return fail(path, "", "is not a JSON list of events");
  std::vector<ScriptedEvent> events;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto event = scripted_event(list[i]);
    const std::string where = fmt::format("event {}", i);
    if (!event)
      return fail(path, where,
                  "expected \"step\" and one of \"move\", \"button\" with \"down\" and \"at\", "
                  "\"scroll\" with \"at\", \"key\" with \"down\", \"type\", \"resize\" or "
                  "\"lose_context\"");
    if (!events.empty() && event->step < events.back().step)
      return fail(path, where + ": step", "expected the order of the steps");
    events.push_back(*event);
  }
  return events;
}

}  // namespace fluxgs::cli
