// Sorting on a thread of its own.
#pragma once

#include <array>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "sort/cpu_radix_sort.h"
#include "sort/sorter.h"

namespace fluxgs::sort {

/// An order of the splats, and the view that it belongs to.
struct IndexBuffer {
  std::vector<std::uint32_t> indices;  ///< as many as the scene has splats
  std::uint32_t count = 0;             ///< of valid ones
  std::uint64_t ticket = 0;            ///< the number of the request
};

/// Holding one keeps it from being overwritten: the thread takes a buffer that nobody holds.
using SharedIndices = std::shared_ptr<const IndexBuffer>;

/// A thread that sorts splats by depth, always for the newest view it was asked for. Nothing is
/// allocated after the constructor as long as the caller holds at most one result at a time.
class SortThread {
 public:
  /// The positions are relative to the scene's origin; splats that are not finite are never listed.
  explicit SortThread(std::vector<glm::vec3> positions);
  ~SortThread();
  SortThread(const SortThread&) = delete;
  SortThread& operator=(const SortThread&) = delete;

  /// Asks for the order of a view; one that waits to be begun is forgotten. Returns its ticket.
  std::uint64_t request(const SortView& view);

  /// The newest order that is finished; null as long as there is none.
  SharedIndices newest() const;

  /// Waits until the order of that ticket, or of a later one, is finished.
  SharedIndices wait(std::uint64_t ticket) const;

 private:
  void run();
  void sort(const SortView& view, IndexBuffer& into);
  std::shared_ptr<IndexBuffer> free_buffer();

  std::vector<glm::vec3> positions_;
  std::vector<std::uint32_t> keys_;
  RadixScratch scratch_;
  // One that is being written, one that is the newest, one that the caller still holds.
  std::array<std::shared_ptr<IndexBuffer>, 3> pool_;

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::optional<SortView> wanted_;
  std::uint64_t last_ticket_ = 0;
  SharedIndices newest_;
  bool stops_ = false;

  // Not a jthread, which the C++ library of Android's NDK r27 does not have
  std::thread thread_;
};

}  // namespace fluxgs::sort
