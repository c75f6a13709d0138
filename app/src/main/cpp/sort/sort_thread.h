// Sorting on a thread of its own.
#pragma once

#include <array>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "sort/background_sort.h"
#include "sort/depth_sort.h"

namespace fluxgs::sort {

/// A thread that sorts. Nothing is allocated after the constructor as long as the caller holds at
/// most one result at a time: the thread takes a buffer that nobody holds.
class SortThread final : public BackgroundSort {
 public:
  explicit SortThread(std::vector<glm::vec3> positions);
  ~SortThread() override;

  std::uint64_t request(const SortView& view) override;
  SharedIndices newest() override;
  SharedIndices wait(std::uint64_t ticket) override;

 private:
  void run();
  std::shared_ptr<IndexBuffer> free_buffer();

  DepthSort sort_;
  // One that is being written, one that is the newest, one that the caller still holds.
  std::array<std::shared_ptr<IndexBuffer>, 3> pool_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<SortView> wanted_;
  std::uint64_t last_ticket_ = 0;
  SharedIndices newest_;
  bool stops_ = false;

  // Not a jthread, which the C++ library of Android's NDK r27 does not have
  std::thread thread_;
};

}  // namespace fluxgs::sort
