#include "trainer/data/photos/match_pairs.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "trainer/data/file_bytes.h"

namespace fluxgs {
namespace {

namespace fs = std::filesystem;

constexpr int kWords = 32, kDescriptor = 128;
constexpr int kLookAlikes = 12, kNearByGps = 6;
constexpr int kSteps[] = {1, 2, 3, 4, 6, 8, 12, 16};  // in the order of the names

using PairSet = std::set<std::pair<int, int>>;

void add_pair(PairSet& pairs, int a, int b) {
  if (a != b) pairs.emplace(std::min(a, b), std::max(a, b));
}

/// Square roots of SIFT features scaled to a sum of 1 (Arandjelović and Zisserman 2012), a row
/// each.
cv::Mat root_sift(const fs::path& file) {
  constexpr int kSide = 480, kFeatures = 400;
  if (!is_file(file)) return {};
  cv::Mat grey = cv::imread(file.string(), cv::IMREAD_GRAYSCALE), descriptors;
  if (grey.empty()) return {};
  const double scale = static_cast<double>(kSide) / std::max(grey.cols, grey.rows);
  if (scale < 1) cv::resize(grey, grey, {}, scale, scale, cv::INTER_AREA);
  std::vector<cv::KeyPoint> keypoints;
  cv::SIFT::create(kFeatures)->detectAndCompute(grey, cv::noArray(), keypoints, descriptors);
  for (int row = 0; row < descriptors.rows; ++row) {
    cv::Mat d = descriptors.row(row);
    d /= std::max(cv::norm(d, cv::NORM_L1), 1e-9);
    cv::sqrt(d, d);
  }
  return descriptors;
}

/// Centres of the clusters of a sample of the features; empty if there are too few.
cv::Mat learn_words(const std::vector<cv::Mat>& features) {
  constexpr int kMostSamples = 40'000;
  int total = 0;
  for (const cv::Mat& f : features) total += f.rows;
  const int step = std::max(1, total / kMostSamples);
  cv::Mat samples, labels, words;
  int index = 0;
  for (const cv::Mat& f : features)
    for (int row = 0; row < f.rows; ++row)
      if (index++ % step == 0) samples.push_back(f.row(row));
  if (samples.rows < 4 * kWords) return {};
  cv::theRNG().state = 1;
  const cv::TermCriteria stop(cv::TermCriteria::COUNT, 12, 0);
  cv::kmeans(samples, kWords, labels, stop, 1, cv::KMEANS_PP_CENTERS, words);
  return words;
}

/// The sums of the differences between features and their words, each word's scaled to length 1,
/// and the whole, too.
cv::Mat vlad_of(const cv::Mat& features, const cv::Mat& words) {
  cv::Mat vlad = cv::Mat::zeros(kWords, kDescriptor, CV_32F);
  for (int row = 0; row < features.rows; ++row) {
    int nearest = 0;
    double least = HUGE_VAL;
    for (int word = 0; word < kWords; ++word) {
      const double distance = cv::norm(features.row(row), words.row(word), cv::NORM_L2SQR);
      if (distance < least) least = distance, nearest = word;
    }
    vlad.row(nearest) += features.row(row) - words.row(nearest);
  }
  for (int word = 0; word < kWords; ++word) {
    cv::Mat row = vlad.row(word);
    if (const double length = cv::norm(row); length > 0) row /= length;
  }
  cv::Mat flat = vlad.reshape(1, 1);
  if (const double length = cv::norm(flat); length > 0) flat /= length;
  return flat;
}

/// Pairs each photo with the few for which `score` is highest.
template <class Score>
void add_best(int count, int most, const Score& score, PairSet& pairs) {
  std::vector<std::vector<int>> best(static_cast<std::size_t>(count));
  tbb::parallel_for(0, count, [&](int i) {
    std::vector<std::pair<double, int>> others;
    for (int k = 0; k < count; ++k)
      if (const double s = k == i ? -HUGE_VAL : score(i, k); s > -HUGE_VAL)
        others.emplace_back(-s, k);
    const auto end = std::min<std::ptrdiff_t>(most, std::ssize(others));
    std::ranges::partial_sort(others, others.begin() + end);
    for (const auto& [unused, k] : std::span(others).first(static_cast<std::size_t>(end)))
      best[static_cast<std::size_t>(i)].push_back(k);
  });
  for (int i = 0; i < count; ++i)
    for (const int k : best[static_cast<std::size_t>(i)]) add_pair(pairs, i, k);
}

void add_look_alikes(const std::vector<PreparedPhoto>& photos, const fs::path& folder,
                     const StepReport& report, PairSet& pairs) {
  std::vector<cv::Mat> features(photos.size());
  const ProgressReport progress = [&](std::size_t done, std::size_t total) {
    if (report) report("comparing looks", "photos", done, total);
  };
  ProgressCounter counter(progress, photos.size());
  tbb::parallel_for(std::size_t{0}, photos.size(), [&](std::size_t i) {
    features[i] = root_sift(folder / photos[i].copy);
    counter.add_one();
  });
  const cv::Mat words = learn_words(features);
  if (words.empty()) return;
  tbb::parallel_for(std::size_t{0}, photos.size(), [&](std::size_t i) {
    features[i] = features[i].empty() ? cv::Mat() : vlad_of(features[i], words);
  });
  add_best(
      static_cast<int>(photos.size()), kLookAlikes,
      [&](int i, int k) {
        const cv::Mat &a = features[static_cast<std::size_t>(i)],
                      &b = features[static_cast<std::size_t>(k)];
        return a.empty() || b.empty() ? -HUGE_VAL : a.dot(b);
      },
      pairs);
}

/// Metres between two places, on a plane that touches the earth there.
double metres_between(const glm::dvec3& a, const glm::dvec3& b) {
  constexpr double kPerDegree = 111'320;
  const double shrink = std::cos(a.x * std::numbers::pi / 180);
  return glm::length(
      glm::dvec3((a.x - b.x) * kPerDegree, (a.y - b.y) * kPerDegree * shrink, a.z - b.z));
}

void add_near_by_gps(const std::vector<PreparedPhoto>& photos, PairSet& pairs) {
  add_best(
      static_cast<int>(photos.size()), kNearByGps,
      [&](int i, int k) {
        const auto &a = photos[static_cast<std::size_t>(i)].position,
                   &b = photos[static_cast<std::size_t>(k)].position;
        return a && b ? -metres_between(*a, *b) : -HUGE_VAL;
      },
      pairs);
}

}  // namespace

std::vector<std::pair<int, int>> match_pairs(const std::vector<PreparedPhoto>& photos,
                                             const fs::path& folder, const StepReport& report) {
  const int count = static_cast<int>(photos.size());
  PairSet pairs;
  if (photos.size() <= kMostForAllPairs) {
    for (int i = 0; i < count; ++i)
      for (int k = i + 1; k < count; ++k) pairs.emplace(i, k);
  } else {
    for (int i = 0; i < count; ++i)
      for (const int step : kSteps)
        if (i + step < count) pairs.emplace(i, i + step);
    add_look_alikes(photos, folder, report, pairs);
    add_near_by_gps(photos, pairs);
  }
  std::vector<std::pair<int, int>> sorted(pairs.begin(), pairs.end());
  std::ranges::stable_sort(sorted, {}, [](const auto& p) { return p.second - p.first; });
  return sorted;
}

}  // namespace fluxgs
