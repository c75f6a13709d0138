// The page's end of the worker that sorts.
#pragma once

#include <array>
#include <memory>

#include "sort/background_sort.h"

namespace fluxgs::web {

/// Sorts in the page's worker; never waits. Only the newest one is heard.
class WorkerSort final : public sort::BackgroundSort {
 public:
  explicit WorkerSort(const std::vector<glm::vec3>& positions);
  ~WorkerSort() override;

  std::uint64_t request(const sort::SortView& view) override;
  sort::SharedIndices newest() override { return newest_; }
  sort::SharedIndices wait(std::uint64_t) override { return newest_; }

  /// Room for an order of the worker, of so many splats; null where it is of another scene.
  void* room(int scene, std::size_t count);
  /// It was written.
  void came(std::uint64_t ticket, std::uint32_t count);

  /// The one that there is; null before.
  static WorkerSort* current();

 private:
  int scene_;
  std::size_t size_;
  std::array<std::shared_ptr<sort::IndexBuffer>, 3> pool_;  // written, newest, held by the caller
  std::shared_ptr<sort::IndexBuffer> writing_;
  sort::SharedIndices newest_;
  std::uint64_t last_ticket_ = 0;
};

}  // namespace fluxgs::web
