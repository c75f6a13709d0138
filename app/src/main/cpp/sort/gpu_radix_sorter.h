// A radix sort in compute shaders that runs on any ES 3.1 driver.
#pragma once

#include <memory>
#include <vector>

#include "gl/program.h"
#include "sort/sorter.h"

namespace fluxgs::sort {

/// Stable least-significant-digit radix sort by reduce-then-scan (Merrill & Grimshaw 2011). A pass
/// over one digit is three dispatches: count the digits of each block of 2048 keys, scan the counts
/// of each digit over the blocks, scatter. No sub-group operations and no waiting of one work group
/// for another: mobile drivers offer neither dependably. There are only as many passes as the keys
/// of the frame need, but at least two.
///
/// The first pass reads the plain list of keys and leaves the dropped ones out, so compaction in
/// the order of the indices costs nothing extra; the other passes take the number of keys that is
/// left from the GPU (indirect dispatch). The last pass writes only indices, reversed.
class GpuRadixSorter final : public Sorter {
 public:
  /// `digit_bits`: 4…8, of a pass.
  static Expected<std::unique_ptr<GpuRadixSorter>> create(gl::Api& api, int digit_bits);

  bool needs_positions() const override { return false; }
  Expected<void> set_scene(std::uint32_t count, std::uint32_t spare,
                           std::vector<glm::vec3> positions) override;
  void sort(const SortView& view, const gl::Buffer* keys) override;
  /// The same for the first `count` of `keys`, of which `key_bits` matter.
  void sort_keys(const gl::Buffer& keys, std::uint32_t count, int key_bits);
  const gl::Buffer& order() const override { return order_; }
  const gl::Buffer& count() const override { return state_; }

 private:
  GpuRadixSorter(gl::Api& api, int digit_bits) : api_(api), digit_bits_(digit_bits) {}
  Expected<void> compile();
  void first_pass(const gl::Buffer& keys, std::uint32_t count);
  void later_pass(int pass, bool last);

  gl::Api& api_;
  int digit_bits_;
  std::uint32_t count_ = 0;
  struct Step {
    gl::Program first, later;
  };
  Step digits_, scan_, scatter_;
  gl::Program scatter_last_;
  gl::Buffer state_;  // shaders/sort.glsl: State
  gl::Buffer pairs_[2], order_;
};

}  // namespace fluxgs::sort
