#include "fluxgs/io/camera_track.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "io/json_text.h"

namespace fluxgs {
namespace {

using io::found;
using io::member;
using nlohmann::json;

constexpr double kMaxCoordinate = 1e9;
constexpr double kOldFieldOfView = 60, kWidest = 179;  // degrees
constexpr double kDegree = std::numbers::pi / 180;

// Looks up values and keeps the first thing that is wrong.
class TrackReader {
 public:
  TrackReader(const json& root, const std::string& name) : root_(root), name_(name) {}

  Expected<CameraTrack> read() {
    check_version();
    const json& tracks = member(root_, "animTracks");
    if (!tracks.is_array() || tracks.empty())
      return fail(name_, "animTracks",
                  "has no camera animation; expected the settings.json of SuperSplat");
    const json& track = tracks[0];
    CameraTrack result{
        .keys = keys_of(track),
        .seconds = number(member(track, "duration"), "duration", 0.01, kMaxTrackSeconds),
        .smoothness = number_or(0, member(track, "smoothness"), "smoothness", 0, 1),
        .end = end_of(member(track, "loopMode"))};
    if (failed()) return std::unexpected(error_);
    return result;
  }

 private:
  bool failed() const { return !error_.what.empty(); }

  void bad(const std::string& where, std::string what) {
    if (!failed()) error_ = {name_, "animTracks[0]." + where, std::move(what)};
  }

  void check_version() {
    const json& version = member(root_, "version");
    if (version.is_null() || version == 1 || version == 2) return;
    error_ = {name_, "version", fmt::format("{}; expected 1 or 2", found(version))};
  }

  double number(const json& value, const std::string& where, double least, double most) {
    const double x = value.is_number() ? value.get<double>() : NAN;
    if (x >= least && x <= most) return x;
    bad(where, fmt::format("{}; expected a number from {} to {}", found(value), least, most));
    return least;
  }
  double number_or(double otherwise, const json& value, const std::string& where, double least,
                   double most) {
    return value.is_null() ? otherwise : number(value, where, least, most);
  }

  /// So many numbers of the keys. An empty list where they are not there.
  const json& list(const json& values, const char* key, std::size_t count) {
    static const json kNone = json::array();
    const json& numbers = member(values, key);
    const std::string where = fmt::format("keyframes.values.{}", key);
    if (numbers.is_array() && numbers.size() == count) return numbers;
    if (numbers.is_array())
      bad(where, fmt::format("has {} numbers; expected {}", numbers.size(), count));
    else
      bad(where, fmt::format("{}; expected {} numbers", found(numbers), count));
    return kNone;
  }

  /// Takes back the half turn about z that SuperSplat gives to scenes.
  glm::dvec3 point(const json& numbers, const char* key, std::size_t i) {
    glm::dvec3 p(0);
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t at = 3 * i + static_cast<std::size_t>(axis);
      p[axis] = number(numbers[at], fmt::format("keyframes.values.{}[{}]", key, at),
                       -kMaxCoordinate, kMaxCoordinate);
    }
    return {-p.x, -p.y, p.z};
  }

  /// Files of version 1 have one field of view for all keys.
  double field_of_view(const json& numbers, std::size_t i) {
    if (numbers.is_array() && !numbers.empty())
      return number(numbers[i], fmt::format("keyframes.values.fov[{}]", i), 1, kWidest);
    return number_or(kOldFieldOfView, member(member(root_, "camera"), "fov"), "camera.fov", 1,
                     kWidest);
  }

  std::vector<CameraTrack::Key> keys_of(const json& track) {
    const json& frames = member(track, "keyframes");
    const json& times = member(frames, "times");
    if (!times.is_array() || times.empty() || times.size() > kMaxTrackKeys) {
      bad("keyframes.times", fmt::format("expected a list of 1 to {} numbers", kMaxTrackKeys));
      return {};
    }
    const json& values = member(frames, "values");
    const json& positions = list(values, "position", 3 * times.size());
    const json& targets = list(values, "target", 3 * times.size());
    const json& fovs =
        member(values, "fov").is_null() ? member(values, "fov") : list(values, "fov", times.size());
    // Times are frames of a rate; the oldest files have no rate, and times in seconds
    const double rate = number_or(1, member(track, "frameRate"), "frameRate", 0.01, 1000);
    std::vector<CameraTrack::Key> keys;
    for (std::size_t i = 0; i < times.size() && !failed(); ++i) {
      const std::string where = fmt::format("keyframes.times[{}]", i);
      keys.push_back({.seconds = number(times[i], where, 0, kMaxTrackSeconds * rate) / rate,
                      .position = point(positions, "position", i),
                      .target = point(targets, "target", i),
                      .fov = kDegree * field_of_view(fovs, i)});
      if (i > 0 && !(keys[i].seconds > keys[i - 1].seconds))
        bad(where,
            fmt::format("{}; expected a later time than that of the key before", found(times[i])));
    }
    return keys;
  }

  CameraTrack::End end_of(const json& mode) {
    if (mode == "repeat") return CameraTrack::End::repeats;
    if (mode == "pingpong") return CameraTrack::End::returns;
    if (mode != "none")
      bad("loopMode", found(mode) + R"(; expected "none", "repeat" or "pingpong")");
    return CameraTrack::End::stops;
  }

  const json& root_;
  const std::string& name_;
  Error error_;
};

}  // namespace

Expected<CameraTrack> read_supersplat_track(std::span<const std::byte> bytes,
                                            const std::string& name) {
  const auto root = io::parse_json_object(io::as_text(bytes), name, "");
  if (!root) return std::unexpected(root.error());
  return TrackReader(*root, name).read();
}

}  // namespace fluxgs
