#include "trainer/data/triangulate_features.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>

#include <glm/geometric.hpp>

#include "trainer/data/features.h"
#include "trainer/data/scene_focus.h"

namespace fluxgs {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kPairsPerView = 8;
constexpr double kMinParallax = 1 * kDegree;

using Features = std::vector<std::vector<Feature>>;  // of each image
using Matches = std::vector<std::pair<int, int>>;

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
  // atan2 keeps its accuracy at small angles, where acos loses it.
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

/// Unsuitability of a pair: 0 at 10° of parallax between parallel views; infinite where features
/// no longer match.
double pair_cost(const View& a, const View& b, const glm::dvec3& focus) {
  const double parallax = angle_between(focus - a.camera.center(), focus - b.camera.center());
  const double turn = angle_between(a.camera.forward(), b.camera.forward());
  if (parallax < kMinParallax || parallax > 50 * kDegree || turn > 60 * kDegree)
    return std::numeric_limits<double>::infinity();
  return std::abs(std::log(parallax / (10 * kDegree))) + turn / (30 * kDegree);
}

/// Features of all images numbered through, joined by their matches.
class Tracks {
 public:
  explicit Tracks(const Features& features) {
    for (const auto& of_view : features) {
      first_.push_back(parent_.size());
      parent_.resize(parent_.size() + of_view.size());
    }
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }

  void join(int view_a, int feature_a, int view_b, int feature_b) {
    const std::size_t a = root(node(view_a, feature_a)), b = root(node(view_b, feature_b));
    parent_[std::max(a, b)] = std::min(a, b);
  }

  struct Observation {
    std::size_t view, feature;
  };
  /// Every track of two features and more, ordered by image and feature.
  std::vector<std::vector<Observation>> list() {
    std::map<std::size_t, std::vector<Observation>> by_root;
    for (std::size_t view = 0; view < first_.size(); ++view) {
      const std::size_t end = view + 1 < first_.size() ? first_[view + 1] : parent_.size();
      for (std::size_t n = first_[view]; n < end; ++n)
        by_root[root(n)].push_back({view, n - first_[view]});
    }
    std::vector<std::vector<Observation>> tracks;
    for (auto& [unused, track] : by_root)
      if (track.size() >= 2) tracks.push_back(std::move(track));
    return tracks;
  }

 private:
  std::size_t node(int view, int feature) const {
    return first_[static_cast<std::size_t>(view)] + static_cast<std::size_t>(feature);
  }
  std::size_t root(std::size_t n) {
    while (parent_[n] != n) n = parent_[n] = parent_[parent_[n]];
    return n;
  }
  std::vector<std::size_t> first_, parent_;
};

using Track = std::vector<Tracks::Observation>;

/// A track with two features in one image holds a wrong match somewhere.
bool is_consistent(const Track& track) {
  return std::ranges::adjacent_find(track, {}, &Tracks::Observation::view) == track.end();
}

double widest_parallax(const std::vector<Ray>& rays) {
  double widest = 0;
  for (std::size_t i = 0; i < rays.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      widest = std::max(widest, angle_between(rays[i].direction, rays[j].direction));
  return widest;
}

bool reprojects(const glm::dvec3& point, const View& view, const glm::dvec2& pixel) {
  const Camera& c = view.camera;
  const glm::dvec3 p = c.rotation * (point - c.center());
  if (!(p.z > 0)) return false;
  const glm::dvec2 image(c.fx * p.x / p.z + c.cx, c.fy * p.y / p.z + c.cy);
  return glm::distance(image, pixel) <= feature_tolerance(view);
}

std::optional<glm::dvec3> triangulate(const Track& track, const std::vector<View>& views,
                                      const Features& features) {
  std::vector<Ray> rays;
  for (const auto& o : track)
    rays.push_back(pixel_ray(views[o.view].camera, features[o.view][o.feature].pixel));
  if (widest_parallax(rays) < kMinParallax) return std::nullopt;
  const auto point = nearest_point_to_rays(rays);
  if (!point) return std::nullopt;
  for (const auto& o : track)
    if (!reprojects(*point, views[o.view], features[o.view][o.feature].pixel)) return std::nullopt;
  return point;
}

glm::vec3 mean_color(const Track& track, const Features& features) {
  glm::vec3 sum(0);
  for (const auto& o : track) sum += glm::vec3(features[o.view][o.feature].color) / 255.0F;
  return sum / static_cast<float>(track.size());
}

/// Calls work(i) for every i below size.
template <class Work>
void for_each_index(std::size_t size, const Threads& threads, const Work& work) {
  threads.for_pieces(size, 1, [&](std::size_t i, std::size_t) { work(i); });
}

Features find_all_features(const std::vector<View>& views, const Threads& threads) {
  Features features(views.size());
  for_each_index(views.size(), threads,
                 [&](std::size_t i) { features[i] = find_features(views[i]); });
  return features;
}

std::vector<Matches> match_all(const std::vector<View>& views, const Features& features,
                               const std::vector<std::pair<int, int>>& pairs,
                               const Threads& threads, const ProgressReport& progress) {
  ProgressCounter counter(progress, pairs.size());
  std::vector<Matches> matches(pairs.size());
  for_each_index(pairs.size(), threads, [&](std::size_t i) {
    const auto a = static_cast<std::size_t>(pairs[i].first);
    const auto b = static_cast<std::size_t>(pairs[i].second);
    matches[i] = match_features(views[a], features[a], views[b], features[b]);
    counter.add_one();
  });
  return matches;
}

}  // namespace

std::vector<std::pair<int, int>> choose_pairs(const std::vector<View>& views) {
  const std::vector<double> distances = focus_distances(views);
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Camera& camera = views[i].camera;
    const glm::dvec3 focus = camera.center() + distances[i] * camera.forward();
    std::vector<std::pair<double, int>> candidates;
    for (std::size_t j = 0; j < views.size(); ++j) {
      if (i == j) continue;
      const double cost = pair_cost(views[i], views[j], focus);
      if (std::isfinite(cost)) candidates.emplace_back(cost, static_cast<int>(j));
    }
    std::ranges::sort(candidates);
    candidates.resize(std::min<std::size_t>(candidates.size(), kPairsPerView));
    for (const auto& [cost, j] : candidates)
      pairs.emplace_back(std::min(static_cast<int>(i), j), std::max(static_cast<int>(i), j));
  }
  std::ranges::sort(pairs);
  const auto repeated = std::ranges::unique(pairs);
  pairs.erase(repeated.begin(), repeated.end());
  return pairs;
}

PointCloud triangulate_features(const std::vector<View>& views, const Threads& threads,
                                const ProgressReport& progress) {
  const Features features = find_all_features(views, threads);
  const auto pairs = choose_pairs(views);
  const auto matches = match_all(views, features, pairs, threads, progress);
  Tracks joined(features);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    for (const auto& [a, b] : matches[i]) joined.join(pairs[i].first, a, pairs[i].second, b);

  PointCloud cloud{.positions = {}, .colors = {}, .source = "triangulated features"};
  for (const Track& track : joined.list()) {
    if (!is_consistent(track)) continue;
    const auto point = triangulate(track, views, features);
    if (!point) continue;
    cloud.positions.emplace_back(*point);
    cloud.colors.push_back(mean_color(track, features));
  }
  return cloud;
}

}  // namespace fluxgs
