#include "trainer/data/features.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "trainer/data/photo_memory.h"

namespace fluxgs {
namespace {

constexpr int kLongestSide = 800, kMaxFeatures = 2000;
constexpr int kLargestDistance2 = 300 * 300;  // Descriptors have a length of about 512.
constexpr double kRatio = 0.8;

/// The factor from the image to the copy that features are found on, ≤ 1.
double feature_scale(const View& view) {
  return std::min(1.0,
                  static_cast<double>(kLongestSide) / std::max(view.rgb.width, view.rgb.height));
}

cv::Mat feature_image(const View& view) {
  // OpenCV has no const matrices over foreign memory; nothing writes to this one.
  auto* pixels = const_cast<std::uint8_t*>(view.rgb.pixels.data());
  cv::Mat grey;
  cv::cvtColor(cv::Mat(view.rgb.height, view.rgb.width, CV_8UC3, pixels), grey, cv::COLOR_RGB2GRAY);
  const double scale = feature_scale(view);
  if (scale < 1.0) {
    const cv::Size size(std::max(1, static_cast<int>(std::lround(grey.cols * scale))),
                        std::max(1, static_cast<int>(std::lround(grey.rows * scale))));
    cv::Mat reduced;
    cv::resize(grey, reduced, size, 0, 0, cv::INTER_AREA);
    return reduced;
  }
  return grey;
}

glm::u8vec3 color_at(const Image<std::uint8_t>& image, const glm::dvec2& pixel) {
  const int x = std::clamp(static_cast<int>(std::floor(pixel.x)), 0, image.width - 1);
  const int y = std::clamp(static_cast<int>(std::floor(pixel.y)), 0, image.height - 1);
  const std::uint8_t* rgb = image.at(x, y);
  return {rgb[0], rgb[1], rgb[2]};
}

int distance2(const Feature& a, const Feature& b) {
  int sum = 0;
  for (std::size_t i = 0; i < a.descriptor.size(); ++i) {
    const int difference = int{a.descriptor[i]} - int{b.descriptor[i]};
    sum += difference * difference;
  }
  return sum;
}

/// F with xᵦᵀ·F·xₐ = 0 for the images xₐ, xᵦ (px) of one point: K⁻ᵀ[t]ₓRK⁻¹ (Hartley & Zisserman,
/// equation 9.2).
glm::dmat3 fundamental_matrix(const Camera& a, const Camera& b) {
  const auto inverse_intrinsics = [](const Camera& c) {
    return glm::dmat3(1 / c.fx, 0, 0, 0, 1 / c.fy, 0, -c.cx / c.fx, -c.cy / c.fy, 1);
  };
  const glm::dmat3 rotation = b.rotation * glm::transpose(a.rotation);
  // t = Rᵦ(cₐ − cᵦ), from centres: the translations cancel badly far from the world's origin.
  const glm::dvec3 t = b.rotation * (a.center() - b.center());
  const glm::dmat3 cross(0, t.z, -t.y, -t.z, 0, t.x, t.y, -t.x, 0);
  return glm::transpose(inverse_intrinsics(b)) * cross * rotation * inverse_intrinsics(a);
}

/// A line scaled such that its dot product with (x, y, 1) is the distance in pixels.
glm::dvec3 normalized_line(const glm::dvec3& line) {
  return line / std::max(glm::length(glm::dvec2(line)), 1e-300);
}

/// The best and second-best match of one feature. Features at the same place, which SIFT gives
/// several orientations, do not compete with each other.
struct Best {
  int index = -1, first = std::numeric_limits<int>::max(), second = first;

  void offer(int candidate, int distance, const std::vector<Feature>& others) {
    const auto same_place = [&] {
      const glm::dvec2 offset = others[static_cast<std::size_t>(candidate)].pixel -
                                others[static_cast<std::size_t>(index)].pixel;
      return glm::dot(offset, offset) < 9.0;
    };
    if (distance < first) {
      if (index >= 0 && !same_place()) second = first;
      first = distance;
      index = candidate;
    } else if (distance < second && !same_place()) {
      second = distance;
    }
  }

  bool is_clear() const {
    return index >= 0 && first < kLargestDistance2 && first < kRatio * kRatio * second;
  }
};

}  // namespace

double feature_tolerance(const View& view) { return 2.0 / feature_scale(view); }

std::vector<Feature> find_features(const View& view) {
  const cv::Mat grey = feature_image(view);
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  const auto sift = cv::SIFT::create(kMaxFeatures, 3, 0.04, 10, 1.6, CV_8U);
  sift->detectAndCompute(grey, cv::noArray(), keypoints, descriptors);

  // OpenCV's centre of the first pixel is at 0. Its SIFT doubles the image first and maps back by
  // halving, which leaves a quarter of a pixel.
  constexpr double kOffset = 0.5 - 0.25;
  const glm::dvec2 scale(static_cast<double>(view.rgb.width) / grey.cols,
                         static_cast<double>(view.rgb.height) / grey.rows);
  std::vector<Feature> features(keypoints.size());
  for (std::size_t i = 0; i < features.size(); ++i) {
    features[i].pixel =
        scale * glm::dvec2(keypoints[i].pt.x + kOffset, keypoints[i].pt.y + kOffset);
    features[i].color = color_at(view.rgb, features[i].pixel);
    std::copy_n(descriptors.ptr<std::uint8_t>(static_cast<int>(i)), 128,
                features[i].descriptor.begin());
  }
  let_go(view);
  return features;
}

std::vector<std::pair<int, int>> match_features(const View& view_a,
                                                const std::vector<Feature>& features_a,
                                                const View& view_b,
                                                const std::vector<Feature>& features_b) {
  const glm::dmat3 to_b = fundamental_matrix(view_a.camera, view_b.camera);
  const glm::dmat3 to_a = glm::transpose(to_b);
  const double tolerance_a = feature_tolerance(view_a), tolerance_b = feature_tolerance(view_b);
  std::vector<glm::dvec3> lines_in_a;
  lines_in_a.reserve(features_b.size());
  for (const Feature& b : features_b)
    lines_in_a.push_back(normalized_line(to_a * glm::dvec3(b.pixel, 1)));

  std::vector<Best> best_of_a(features_a.size()), best_of_b(features_b.size());
  for (std::size_t i = 0; i < features_a.size(); ++i) {
    const glm::dvec3 a(features_a[i].pixel, 1);
    const glm::dvec3 line_in_b = normalized_line(to_b * a);
    for (std::size_t j = 0; j < features_b.size(); ++j) {
      if (std::abs(glm::dot(line_in_b, glm::dvec3(features_b[j].pixel, 1))) > tolerance_b) continue;
      if (std::abs(glm::dot(lines_in_a[j], a)) > tolerance_a) continue;
      const int distance = distance2(features_a[i], features_b[j]);
      best_of_a[i].offer(static_cast<int>(j), distance, features_b);
      best_of_b[j].offer(static_cast<int>(i), distance, features_a);
    }
  }

  std::vector<std::pair<int, int>> matches;
  for (std::size_t i = 0; i < features_a.size(); ++i) {
    if (!best_of_a[i].is_clear()) continue;
    const Best& back = best_of_b[static_cast<std::size_t>(best_of_a[i].index)];
    if (back.is_clear() && back.index == static_cast<int>(i))
      matches.emplace_back(static_cast<int>(i), best_of_a[i].index);
  }
  return matches;
}

}  // namespace fluxgs
