#include "io/whole_cloud.h"

namespace fluxgs::io {
namespace {

template <class T>
void copy_to(const std::vector<T>& from, std::vector<T>& to, std::size_t at) {
  std::ranges::copy(from, to.begin() + static_cast<std::ptrdiff_t>(at));
}

/// Bands that the part does not have stay zeros.
void copy_sh(const SplatCloud& part, SplatCloud& cloud, std::size_t at) {
  const auto from = static_cast<std::size_t>(sh_rest_count(part.sh_degree));
  const auto to = static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  if (from == to) return copy_to(part.sh_rest, cloud.sh_rest, at * to);
  for (std::size_t i = 0; i < part.size(); ++i)
    std::copy_n(part.sh_rest.data() + i * from, from, cloud.sh_rest.data() + (at + i) * to);
}

}  // namespace

Expected<int> WholeCloud::begin(const ComingSplats& coming) {
  cloud_.sh_degree = coming.sh_degree;
  count_ = coming.count;
  return coming.sh_degree;
}

Expected<void> WholeCloud::take(SplatCloud& part) {
  if (taken_ == 0 && part.size() == count_ && part.sh_degree == cloud_.sh_degree) {
    cloud_ = std::move(part);
    taken_ = count_;
    return {};
  }
  if (cloud_.size() != count_) {
    auto cloud = allocate_cloud(count_, cloud_.sh_degree, name_);
    if (!cloud) return std::unexpected(cloud.error());
    cloud_ = std::move(*cloud);
  }
  copy_to(part.positions, cloud_.positions, taken_);
  copy_to(part.log_scales, cloud_.log_scales, taken_);
  copy_to(part.rotations, cloud_.rotations, taken_);
  copy_to(part.opacity_logits, cloud_.opacity_logits, taken_);
  copy_to(part.sh_dc, cloud_.sh_dc, taken_);
  copy_sh(part, cloud_, taken_);
  taken_ += part.size();
  return {};
}

SplatCloud WholeCloud::finish(const ScreenFilter& filter) {
  cloud_.filter = filter;
  cloud_.resize(taken_);
  return std::move(cloud_);
}

}  // namespace fluxgs::io
