#include "trainer/core/parameters.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <new>

namespace fluxgs {
namespace {

constexpr std::size_t kAlignment = 64;

float* allocate(std::size_t count) {
  const std::size_t bytes = std::max<std::size_t>(count, PlanarFloats::kPadding) * sizeof(float);
  void* p = std::aligned_alloc(kAlignment, (bytes + kAlignment - 1) / kAlignment * kAlignment);
  if (!p) throw std::bad_alloc();
  std::memset(p, 0, bytes);
  return static_cast<float*>(p);
}

}  // namespace

void PlanarFloats::Free::operator()(float* p) const { std::free(p); }

PlanarFloats::PlanarFloats(int rows, std::size_t size)
    : rows_(rows),
      size_(size),
      stride_((size + kPadding - 1) / kPadding * kPadding),
      data_(allocate(static_cast<std::size_t>(rows) * stride_)) {}

PlanarFloats::PlanarFloats(const PlanarFloats& other) : PlanarFloats(other.rows_, other.size_) {
  if (other.data_)
    std::memcpy(data_.get(), other.data_.get(),
                static_cast<std::size_t>(rows_) * stride_ * sizeof(float));
}

PlanarFloats& PlanarFloats::operator=(const PlanarFloats& other) {
  return *this = PlanarFloats(other);
}

PlanarFloats PlanarFloats::gather(const std::vector<std::uint32_t>& order) const {
  PlanarFloats out(rows_, order.size());
  for (int r = 0; r < rows_; ++r) {
    const float* from = row(r);
    float* to = out.row(r);
    for (std::size_t i = 0; i < order.size(); ++i) to[i] = order[i] == kNew ? 0.0f : from[order[i]];
  }
  return out;
}

int sh_degree_of(const PlanarFloats& parameters) {
  int degree = 0;
  while (degree < 3 && row::count(degree) < parameters.rows()) ++degree;
  return degree;
}

PlanarFloats to_parameters(const SplatCloud& cloud, int sh_degree) {
  PlanarFloats p(row::count(sh_degree), cloud.size());
  const int rest = sh_rest_count(cloud.sh_degree);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      p.row(row::position + c)[i] = cloud.positions[i][c];
      p.row(row::log_scale + c)[i] = cloud.log_scales[i][c];
      p.row(row::sh_dc + c)[i] = cloud.sh_dc[i][c];
      for (int k = 0; k < std::min(rest, sh_rest_count(sh_degree)); ++k)
        p.row(row::sh_rest + 3 * k + c)[i] =
            cloud.sh_rest[i * static_cast<std::size_t>(rest) + static_cast<std::size_t>(k)][c];
    }
    const glm::quat& q = cloud.rotations[i];
    p.row(row::rotation)[i] = q.w;
    p.row(row::rotation + 1)[i] = q.x;
    p.row(row::rotation + 2)[i] = q.y;
    p.row(row::rotation + 3)[i] = q.z;
    p.row(row::opacity)[i] = cloud.opacity_logits[i];
  }
  return p;
}

SplatCloud to_cloud(const PlanarFloats& p, int sh_degree) {
  SplatCloud cloud;
  cloud.sh_degree = sh_degree;
  cloud.resize(p.size());
  const int rest = sh_rest_count(sh_degree);
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      cloud.positions[i][c] = p.row(row::position + c)[i];
      cloud.log_scales[i][c] = p.row(row::log_scale + c)[i];
      cloud.sh_dc[i][c] = p.row(row::sh_dc + c)[i];
      for (int k = 0; k < rest; ++k)
        cloud.sh_rest[i * static_cast<std::size_t>(rest) + static_cast<std::size_t>(k)][c] =
            p.row(row::sh_rest + 3 * k + c)[i];
    }
    cloud.rotations[i] = glm::quat(p.row(row::rotation)[i], p.row(row::rotation + 1)[i],
                                   p.row(row::rotation + 2)[i], p.row(row::rotation + 3)[i]);
    cloud.opacity_logits[i] = p.row(row::opacity)[i];
  }
  return cloud;
}

}  // namespace fluxgs
