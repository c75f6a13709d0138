// Sorting on the CPU beside the drawing.
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include "sort/background_sort.h"
#include "sort/uploaded_order.h"

namespace fluxgs::sort {

/// The paper's decoupled sort (Flux-GS, section on the mobile renderer): frames are drawn with the
/// newest order that a background sort has finished, and never wait for it but the first time. It
/// may belong to a view some frames ago.
class AsyncCpuSorter final : public Sorter {
 public:
  /// `make`: the sort of a scene; empty: a SortThread. Where that cannot wait nothing is drawn
  /// until the first order is there.
  static Expected<std::unique_ptr<AsyncCpuSorter>> create(gl::Api& api,
                                                          OrderPlace place = OrderPlace::buffers,
                                                          MakeBackgroundSort make = {});

  bool needs_positions() const override { return true; }
  Expected<void> set_scene(std::uint32_t count, std::uint32_t spare,
                           std::vector<glm::vec3> positions) override;
  void sort(const SortView& view, const gl::Buffer* keys) override;
  void collect() override;
  bool is_current() const override { return shown_ == wanted_; }
  double latency() const override { return latency_; }
  void finish() override;
  const gl::Buffer& order() const override { return slots_[current_].order(); }
  const gl::Buffer& count() const override { return slots_[current_].count(); }
  const OrderTexture* order_texture() const override { return slots_[current_].texture(); }

 private:
  AsyncCpuSorter(gl::Api& api, OrderPlace place, MakeBackgroundSort make)
      : api_(api), place_(place), make_(std::move(make)) {}
  using Clock = std::chrono::steady_clock;

  void show(const SharedIndices& indices);

  gl::Api& api_;
  OrderPlace place_;
  MakeBackgroundSort make_;
  std::unique_ptr<BackgroundSort> sort_;
  std::uint64_t wanted_ = 0, shown_ = 0;       // tickets
  std::array<Clock::time_point, 64> asked_{};  // for the last tickets
  double latency_ = 0;
  // Frames on their way through the GPU still read the orders before; three, as many as drivers
  // queue frames, keep the upload from waiting for them.
  std::array<UploadedOrder, 3> slots_;
  std::size_t current_ = 0;
};

}  // namespace fluxgs::sort
