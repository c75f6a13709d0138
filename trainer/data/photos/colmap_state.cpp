#include "trainer/data/photos/colmap_state.h"

#include <span>

#include <nlohmann/json.hpp>

#include "fluxgs/io/file.h"
#include "trainer/data/file_bytes.h"

namespace fluxgs {
namespace {

using Json = nlohmann::json;

constexpr int kVersion = 1;

std::filesystem::path state_file(const std::filesystem::path& work) { return work / "state.json"; }

}  // namespace

ColmapState read_colmap_state(const std::filesystem::path& work) {
  constexpr std::uint64_t kMost = 1 << 28;
  const auto text = read_text(state_file(work), kMost);
  if (!text) return {};
  try {
    const Json json = Json::parse(*text);
    if (json.at("version") != kVersion) return {};
    ColmapState state;
    json.at("cameras").get_to(state.cameras);
    json.at("photos").get_to(state.photos);
    json.at("features").get_to(state.features);
    json.at("mapped").get_to(state.mapped);
    json.at("video_bytes").get_to(state.video_bytes);
    json.at("video_frames").get_to(state.video_frames);
    return state;
  } catch (const Json::exception&) {
    return {};
  }
}

Expected<void> write_colmap_state(const std::filesystem::path& work, const ColmapState& state) {
  const std::string text = Json{
      {"version", kVersion},
      {"cameras", state.cameras},
      {"photos", state.photos},
      {"features", state.features},
      {"mapped", state.mapped},
      {"video_bytes", state.video_bytes},
      {"video_frames",
       state.video_frames}}.dump(1, ' ', false, Json::error_handler_t::replace);
  return write_file_atomic(state_file(work), std::as_bytes(std::span(text)));
}

}  // namespace fluxgs
