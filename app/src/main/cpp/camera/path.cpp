#include "camera/path.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace fluxgs::camera {
namespace {

using Pose = CameraPath::Pose;
using Key = CameraPath::Key;

constexpr std::size_t kTarget = 3, kTurn = 6, kDistance = 10, kFov = 11;
constexpr double kNarrowest = 0.01, kWidest = 3.1;  // fields of view, radians
constexpr std::size_t kSteps = 64;                  // of the way between two views
constexpr std::size_t kOrbitViews = 36;

glm::dvec3 point_of(const Pose& p, std::size_t at) { return {p[at], p[at + 1], p[at + 2]}; }

glm::dquat turn_of(const Pose& p) { return {p[kTurn], p[kTurn + 1], p[kTurn + 2], p[kTurn + 3]}; }

Pose pose_of(const ViewState& view) {
  const glm::dvec3 from = eye(view), to = view.target;
  const glm::dquat& q = view.orientation;
  return {from.x,
          from.y,
          from.z,
          to.x,
          to.y,
          to.z,
          q.w,
          q.x,
          q.y,
          q.z,
          std::log(std::max(view.distance, 1e-9)),
          view.fov};
}

/// Takes the quaternion of an orientation, q or −q, that is nearer to the one before.
void turn_shorter(const Pose& before, Pose& pose) {
  if (glm::dot(turn_of(before), turn_of(pose)) >= 0) return;
  for (std::size_t i = kTurn; i < kTurn + 4; ++i) pose[i] = -pose[i];
}

Pose slope(const Key& a, const Key& b) {
  Pose s;
  for (std::size_t i = 0; i < s.size(); ++i) s[i] = (b.pose[i] - a.pose[i]) / (b.knot - a.knot);
  return s;
}

/// The mean of the slopes beside a key: with equal weights in SuperSplat's animations, else as
/// Catmull-Rom splines have them.
Pose tangent(const CameraPath& path, std::size_t i) {
  const std::vector<Key>& keys = path.keys;
  const std::size_t last = keys.size() - 1;
  Pose before = slope(keys[i > 0 ? i - 1 : 0], keys[i > 0 ? i : 1]);
  const Pose after = slope(keys[i < last ? i : last - 1], keys[i < last ? i + 1 : last]);
  double weight = 0.5;
  if (!path.ways.empty() && i > 0 && i < last)
    weight = (keys[i].knot - keys[i - 1].knot) / (keys[i + 1].knot - keys[i - 1].knot);
  for (std::size_t k = 0; k < before.size(); ++k)
    before[k] = path.smoothness * std::lerp(before[k], after[k], weight);
  return before;
}

Pose pose_at(const CameraPath& path, double knot) {
  const std::vector<Key>& keys = path.keys;
  const auto after = std::ranges::upper_bound(keys, knot, {}, &Key::knot);
  if (after == keys.begin()) return keys.front().pose;
  if (after == keys.end()) return keys.back().pose;
  const auto i = static_cast<std::size_t>(after - keys.begin()) - 1;
  const double step = keys[i + 1].knot - keys[i].knot;
  const double t = (knot - keys[i].knot) / step;
  const Pose &a = keys[i].pose, &b = keys[i + 1].pose;
  const Pose ta = tangent(path, i), tb = tangent(path, i + 1);
  const double to_b = t * t * (3 - 2 * t), out = t * (1 - t) * (1 - t), in = t * t * (t - 1);
  Pose p;
  for (std::size_t k = 0; k < p.size(); ++k)
    p[k] = a[k] + (b[k] - a[k]) * to_b + step * (ta[k] * out + tb[k] * in);
  return p;
}

/// The field of view of the image's shorter side.
double fov_of(const CameraPath& path, const Pose& pose, const glm::dvec2& size) {
  const double fov = std::clamp(pose[kFov], kNarrowest, kWidest);
  if (!path.of_longer_side) return fov;
  const double shorter = std::max(std::min(size.x, size.y), 1.0);
  const double longer = std::max({size.x, size.y, 1.0});
  return 2 * std::atan(std::tan(0.5 * fov) * shorter / longer);
}

ViewState view_of(const CameraPath& path, const Pose& pose, const glm::dvec2& size) {
  const double fov = fov_of(path, pose, size);
  if (path.up) return view_between(point_of(pose, 0), point_of(pose, kTarget), *path.up, fov);
  ViewState view;
  const glm::dquat turn = turn_of(pose);
  if (glm::length(turn) > 1e-6) view.orientation = glm::normalize(turn);
  view.distance = std::exp(pose[kDistance]);
  view.target = point_of(pose, 0) + view.distance * forward(view);
  view.fov = fov;
  return view;
}

double angle_between(const glm::dquat& a, const glm::dquat& b) {
  return 2 * std::acos(std::min(std::abs(glm::dot(a, b)), 1.0));
}

/// The distance from a view to the next: the eye's way and the way of a turn at the target.
double way_between(const ViewState& a, const ViewState& b) {
  const double turned = angle_between(a.orientation, b.orientation);
  return std::hypot(glm::distance(eye(a), eye(b)), std::sqrt(a.distance * b.distance) * turned);
}

/// The views with their knots, the square roots of the ways between them.
std::vector<Key> keys_through(std::span<const ViewState> views) {
  std::vector<double> steps;
  double longest = 0;
  for (std::size_t i = 1; i < views.size(); ++i) {
    steps.push_back(std::sqrt(way_between(views[i - 1], views[i])));
    longest = std::max(longest, steps.back());
  }
  const double shortest = longest > 0 ? 1e-3 * longest : 1;  // of equal views
  std::vector<Key> keys{{0, pose_of(views[0])}};
  for (std::size_t i = 1; i < views.size(); ++i) {
    keys.push_back({keys.back().knot + std::max(steps[i - 1], shortest), pose_of(views[i])});
    turn_shorter(keys[i - 1].pose, keys[i].pose);
  }
  return keys;
}

/// Adds the last key before the first and the second one after the last, which is the first again.
void close(std::vector<Key>& keys, double span) {
  Key before = keys[keys.size() - 2], after = keys[1];
  before.knot -= span;
  after.knot += span;
  turn_shorter(keys.front().pose, before.pose);
  turn_shorter(keys.back().pose, after.pose);
  keys.push_back(after);
  keys.insert(keys.begin(), before);
}

void measure_ways(CameraPath& path, std::size_t views) {
  path.ways.assign(1, 0);  // tangents look whether there are any
  const std::size_t steps = kSteps * std::max<std::size_t>(views - 1, 1);
  const glm::dvec2 size(1);
  ViewState before = view_of(path, pose_at(path, 0), size);
  for (std::size_t i = 1; i <= steps; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(steps);
    const ViewState view = view_of(path, pose_at(path, part * path.span), size);
    path.ways.push_back(path.ways.back() + way_between(before, view));
    before = view;
  }
}

/// The knot where the camera is after a part of the way.
double knot_after(const CameraPath& path, double part) {
  const std::vector<double>& ways = path.ways;
  const double way = part * ways.back();
  const auto after = std::ranges::upper_bound(ways, way);
  if (after == ways.end()) return path.span;
  const double length = *after - *(after - 1);
  const double steps =
      static_cast<double>(after - ways.begin()) - 1 + (way - *(after - 1)) / length;
  return path.span * steps / static_cast<double>(ways.size() - 1);
}

/// The time within once through.
double time_within(const CameraPath& path, double seconds) {
  const double all = path.seconds, time = std::isfinite(seconds) ? std::max(seconds, 0.0) : 0;
  switch (path.end) {
    case PathEnd::repeats:
      return std::fmod(time, all);
    case PathEnd::returns:
      return all - std::abs(std::fmod(time, 2 * all) - all);
    case PathEnd::stops:
      break;
  }
  return std::min(time, all);
}

}  // namespace

ViewState view_at(const CameraPath& path, double seconds, const glm::dvec2& size) {
  const double time = time_within(path, seconds);
  const double knot = path.ways.empty() ? time : knot_after(path, time / path.seconds);
  return view_of(path, pose_at(path, knot), size);
}

CameraPath path_through(std::span<const ViewState> views, bool closed, double seconds) {
  std::vector<ViewState> stops(views.begin(), views.end());
  closed = closed && stops.size() > 1;
  if (closed) stops.push_back(stops.front());
  CameraPath path{.keys = keys_through(stops),
                  .seconds = std::min(std::max(1e-3, seconds), 1e5),
                  .end = closed ? PathEnd::repeats : PathEnd::stops};
  path.span = path.keys.back().knot;
  if (closed) close(path.keys, path.span);
  measure_ways(path, stops.size());
  return path;
}

CameraPath orbit_path(const ViewState& view, const glm::dvec3& up, double seconds) {
  std::vector<ViewState> views(kOrbitViews, view);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / kOrbitViews;
    views[i].orientation = glm::normalize(glm::angleAxis(angle, up) * view.orientation);
  }
  return path_through(views, true, seconds);
}

CameraPath path_of(const CameraTrack& track) {
  constexpr glm::dvec3 kUp(0, -1, 0);
  CameraPath path{.smoothness = track.smoothness,
                  .of_longer_side = true,
                  .up = kUp,
                  .seconds = track.seconds,
                  .end = track.end};
  for (const CameraTrack::Key& key : track.keys)
    path.keys.push_back(
        {key.seconds, pose_of(view_between(key.position, key.target, kUp, key.fov))});
  const bool repeats = track.end == PathEnd::repeats && track.keys.size() > 1;
  if (!repeats) return path;
  // A second for the way back to the first key, where the last one is at the very end
  const double last = path.keys.back().knot;
  path.span = track.seconds > last ? track.seconds : last + 1;
  path.keys.push_back({path.keys.front().knot + path.span, path.keys.front().pose});
  close(path.keys, path.span);
  return path;
}

}  // namespace fluxgs::camera
