#include "sort/async_cpu_sorter.h"

#include "sort/sort_thread.h"

namespace fluxgs::sort {

Expected<std::unique_ptr<AsyncCpuSorter>> AsyncCpuSorter::create(gl::Api& api, OrderPlace place,
                                                                 MakeBackgroundSort make) {
  if (!make)
    make = [](std::vector<glm::vec3> positions) {
      return std::make_unique<SortThread>(std::move(positions));
    };
  std::unique_ptr<AsyncCpuSorter> sorter(new AsyncCpuSorter(api, place, std::move(make)));
  if (auto ok = sorter->set_scene(0, 0, {}); !ok) return std::unexpected(ok.error());
  return sorter;
}

Expected<void> AsyncCpuSorter::set_scene(std::uint32_t count, std::uint32_t spare,
                                         std::vector<glm::vec3> positions) {
  sort_ = make_(std::move(positions));
  wanted_ = shown_ = 0;
  for (UploadedOrder& slot : slots_) {
    slot = {};  // There may not be room for both
    auto made =
        gl::assign_or_error(UploadedOrder::create(api_, std::size_t{count} + spare, place_), slot);
    if (!made) return made;
  }
  return {};
}

void AsyncCpuSorter::sort(const SortView& view, const gl::Buffer* /*keys*/) {
  wanted_ = sort_->request(view);
  asked_[wanted_ % asked_.size()] = Clock::now();
  if (shown_ == 0) finish();  // There is nothing yet that could be drawn meanwhile
}

void AsyncCpuSorter::collect() {
  if (shown_ != wanted_) show(sort_->newest());
}

void AsyncCpuSorter::finish() {
  if (shown_ != wanted_) show(sort_->wait(wanted_));
}

void AsyncCpuSorter::show(const SharedIndices& indices) {
  if (!indices || indices->ticket == shown_) return;
  current_ = (current_ + 1) % slots_.size();
  slots_[current_].write({indices->indices.data(), indices->count});
  shown_ = indices->ticket;
  const std::chrono::duration<double> passed = Clock::now() - asked_[shown_ % asked_.size()];
  latency_ = passed.count();
}

}  // namespace fluxgs::sort
