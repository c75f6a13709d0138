#include "viewer/session_json.h"

#include <nlohmann/json.hpp>

namespace fluxgs::viewer {
namespace {

using nlohmann::json;

const char* name_of(LoadPhase phase) {
  switch (phase) {
    case LoadPhase::idle:
      return "idle";
    case LoadPhase::reading:
      return "reading";
    case LoadPhase::decoding:
      return "decoding";
    case LoadPhase::ready:
      return "ready";
    case LoadPhase::failed:
      return "failed";
    case LoadPhase::cancelled:
      return "cancelled";
  }
  return "";
}

const char* name_of(Motion motion) {
  switch (motion) {
    case Motion::none:
      break;
    case Motion::drift:
      return "drift";
    case Motion::path:
      return "path";
    case Motion::walk:
      return "walk";
  }
  return "";
}

// Errors may quote the bytes of strangers.
std::string text_of(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

json json_of(const LoadState& s) {
  const SceneEstimate estimate = s.estimate.value_or(SceneEstimate{});
  return {{"phase", name_of(s.phase)}, {"read", s.read},
          {"bytes", s.bytes},          {"error", s.error},
          {"problem", s.problem},      {"format", estimate.format},
          {"splats", estimate.splats}, {"shDegree", estimate.sh_degree},
          {"memory", estimate.decoded}};
}

json json_of(const ViewerStats& s) {
  return {
      {"fps", s.frames_per_second}, {"goal", s.goal},          {"frameMs", s.frame_ms},
      {"sortMs", s.sort_ms},        {"drawn", s.drawn},        {"shown", s.shown},
      {"splats", s.splats},         {"shDegree", s.sh_degree}, {"fileShDegree", s.file_sh_degree},
      {"width", s.width},           {"height", s.height},      {"scale", s.scale},
      {"memory", s.memory},         {"reduced", s.reduced},    {"image", s.image},
      {"coolest", s.coolest}};
}

}  // namespace

std::string to_json(const SessionState& s) {
  return text_of({{"loading", json_of(s.loading)},
                  {"hasScene", s.has_scene},
                  {"drawn", s.drawn},
                  {"coarse", s.coarse},
                  {"shown", s.shown},
                  {"flipped", s.flipped},
                  {"motion", name_of(s.motion)},
                  {"error", s.error},
                  {"contexts", s.contexts},
                  {"dropped", s.dropped},
                  {"firstFrameMs", s.first_frame_ms},
                  {"stats", json_of(s.stats)}});
}

std::string to_json(const LoadState& s) { return text_of(json_of(s)); }

std::string to_json(const RunState& s) {
  const json rows = json::parse(s.rows, nullptr, false);
  return text_of({{"running", s.running},
                  {"done", s.done},
                  {"all", s.all},
                  {"rows", rows.is_discarded() ? json::array() : rows},
                  {"stopped", s.stopped},
                  {"error", s.error}});
}

}  // namespace fluxgs::viewer
