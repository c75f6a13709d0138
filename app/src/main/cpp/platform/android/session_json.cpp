#include "platform/android/session_json.h"

#include <nlohmann/json.hpp>

namespace fluxgs::android {
namespace {

using nlohmann::json;

const char* name_of(viewer::LoadPhase phase) {
  using viewer::LoadPhase;
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

const char* name_of(viewer::Motion motion) {
  switch (motion) {
    case viewer::Motion::none:
      break;
    case viewer::Motion::drift:
      return "drift";
    case viewer::Motion::path:
      return "path";
    case viewer::Motion::walk:
      return "walk";
  }
  return "";
}

// Errors may quote the bytes of strangers.
std::string text_of(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

json json_of(const viewer::LoadState& s) {
  const SceneEstimate estimate = s.estimate.value_or(SceneEstimate{});
  return {{"phase", name_of(s.phase)}, {"read", s.read},
          {"bytes", s.bytes},          {"error", s.error},
          {"problem", s.problem},      {"format", estimate.format},
          {"splats", estimate.splats}, {"shDegree", estimate.sh_degree},
          {"memory", estimate.decoded}};
}

json json_of(const viewer::ViewerStats& s) {
  return {
      {"fps", s.frames_per_second}, {"goal", s.goal},          {"frameMs", s.frame_ms},
      {"sortMs", s.sort_ms},        {"drawn", s.drawn},        {"shown", s.shown},
      {"splats", s.splats},         {"shDegree", s.sh_degree}, {"fileShDegree", s.file_sh_degree},
      {"width", s.width},           {"height", s.height},      {"scale", s.scale},
      {"memory", s.memory},         {"reduced", s.reduced},    {"image", s.image},
      {"coolest", s.coolest}};
}

}  // namespace

std::string to_json(const viewer::SessionState& s) {
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

std::string to_json(const viewer::RunState& s) {
  const json rows = json::parse(s.rows, nullptr, false);
  return text_of({{"running", s.running},
                  {"done", s.done},
                  {"all", s.all},
                  {"rows", rows.is_discarded() ? json::array() : rows},
                  {"stopped", s.stopped},
                  {"error", s.error}});
}

}  // namespace fluxgs::android
