#include "trainer/train/initialize.h"

#include <algorithm>
#include <cmath>

#include <nanoflann.hpp>

#include "fluxgs/math/logistic.h"
#include "fluxgs/math/spherical_harmonics.h"

namespace fluxgs {
namespace {

/// Interface that nanoflann asks of a set of points.
struct Points {
  const std::vector<glm::vec3>& all;
  std::size_t kdtree_get_point_count() const { return all.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return all[i][static_cast<int>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Points>,
                                                 Points, 3, std::uint32_t>;

constexpr std::size_t kNeighbours = 3;
constexpr float kMinSquaredDistance = 1e-7f;  // points may coincide; as 3DGS does

float mean_squared_distance(const Tree& tree, const glm::vec3& at, std::size_t points) {
  std::uint32_t index[kNeighbours + 1];
  float squared[kNeighbours + 1];
  const std::size_t wanted = std::min(points, kNeighbours + 1);  // the point itself comes first
  const std::size_t found = tree.knnSearch(&at[0], wanted, index, squared);
  float total = 0;
  for (std::size_t k = 1; k < found; ++k) total += squared[k];
  return found > 1 ? std::max(total / static_cast<float>(found - 1), kMinSquaredDistance) : 1.0f;
}

}  // namespace

SplatCloud splats_from_points(const PointCloud& points, double opacity, const Threads& threads) {
  const std::size_t count = points.positions.size();
  SplatCloud cloud;
  cloud.resize(count);
  if (count == 0) return cloud;
  const Points adaptor{points.positions};
  const Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  const auto opacity_logit = static_cast<float>(logit(opacity));
  threads.for_pieces(count, 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      cloud.positions[i] = points.positions[i];
      cloud.log_scales[i] =
          glm::vec3(0.5f * std::log(mean_squared_distance(tree, points.positions[i], count)));
      cloud.opacity_logits[i] = opacity_logit;
      cloud.sh_dc[i] = (points.colors[i] - 0.5f) / static_cast<float>(math::kSh0);
    }
  });
  return cloud;
}

}  // namespace fluxgs
