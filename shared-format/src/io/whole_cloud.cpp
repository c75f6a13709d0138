#include "io/whole_cloud.h"

namespace fluxgs::io {
namespace {

template <class T>
void append(const std::vector<T>& from, std::vector<T>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

/// Bands that the part does not have are zeros.
void append_sh(const SplatCloud& part, SplatCloud& cloud) {
  if (part.sh_degree == cloud.sh_degree) return append(part.sh_rest, cloud.sh_rest);
  const auto from = static_cast<std::size_t>(sh_rest_count(part.sh_degree));
  const auto to = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  const std::size_t begin = cloud.sh_rest.size();
  cloud.sh_rest.resize(begin + part.size() * to);
  for (std::size_t i = 0; i < part.size(); ++i)
    std::copy_n(part.sh_rest.data() + i * from, from, cloud.sh_rest.data() + begin + i * to);
}

}  // namespace

Expected<int> WholeCloud::begin(const ComingSplats& coming) {
  cloud_.sh_degree = coming.sh_degree;
  count_ = coming.count;
  return coming.sh_degree;
}

Expected<void> WholeCloud::take(SplatCloud& part) {
  if (cloud_.size() == 0 && part.size() == count_ && part.sh_degree == cloud_.sh_degree) {
    cloud_ = std::move(part);
    return {};
  }
  // Others may be most of a scene, and there need not be room for all of it beside them already
  const bool is_small = part.size() == kSplatsOfAPart;
  if (is_small && cloud_.positions.capacity() < count_)
    if (auto reserved = reserve_cloud(count_, name_, cloud_); !reserved) return reserved;
  append(part.positions, cloud_.positions);
  append(part.log_scales, cloud_.log_scales);
  append(part.rotations, cloud_.rotations);
  append(part.opacity_logits, cloud_.opacity_logits);
  append(part.sh_dc, cloud_.sh_dc);
  append_sh(part, cloud_);
  return {};
}

SplatCloud WholeCloud::finish(const ScreenFilter& filter) {
  cloud_.filter = filter;
  return std::move(cloud_);
}

}  // namespace fluxgs::io
