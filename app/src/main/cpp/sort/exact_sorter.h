// The sorter that the others are measured against.
#pragma once

#include <memory>

#include "sort/uploaded_order.h"

namespace fluxgs::sort {

/// Sorts all splats in front of the near plane by their float64 depth with std::stable_sort, while
/// the caller waits. Slow, and obviously right. SortView::keys is not used.
class ExactSorter final : public Sorter {
 public:
  static Expected<std::unique_ptr<ExactSorter>> create(gl::Api& api,
                                                       OrderPlace place = OrderPlace::buffers);

  bool needs_positions() const override { return true; }
  Expected<void> set_scene(std::uint32_t count, std::uint32_t spare,
                           std::vector<glm::vec3> positions) override;
  void sort(const SortView& view, const gl::Buffer* keys) override;
  const gl::Buffer& order() const override { return uploaded_.order(); }
  const gl::Buffer& count() const override { return uploaded_.count(); }
  const OrderTexture* order_texture() const override { return uploaded_.texture(); }

 private:
  ExactSorter(gl::Api& api, OrderPlace place) : api_(api), place_(place) {}

  gl::Api& api_;
  OrderPlace place_;
  std::vector<glm::vec3> positions_;
  std::vector<double> depths_;
  std::vector<std::uint32_t> indices_;
  UploadedOrder uploaded_;
};

/// The indices of the splats deeper than `near_plane`, in the order that Sorter::order() promises.
/// `depths` and `indices` are what it works with; `indices` holds the result.
void sort_exactly(const std::vector<glm::vec3>& positions, const SortView& view,
                  std::vector<double>& depths, std::vector<std::uint32_t>& indices);

}  // namespace fluxgs::sort
