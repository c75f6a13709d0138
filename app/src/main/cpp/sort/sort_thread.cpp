#include "sort/sort_thread.h"

#include <utility>

namespace fluxgs::sort {

SortThread::SortThread(std::vector<glm::vec3> positions) : sort_(std::move(positions)) {
  for (auto& buffer : pool_) {
    buffer = std::make_shared<IndexBuffer>();
    buffer->indices.resize(sort_.size());
  }
  thread_ = std::thread([this] { run(); });
}

SortThread::~SortThread() {
  {
    const std::lock_guard lock(mutex_);
    stops_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

std::uint64_t SortThread::request(const SortView& view) {
  std::uint64_t ticket = 0;
  {
    const std::lock_guard lock(mutex_);
    wanted_ = view;
    ticket = ++last_ticket_;
  }
  changed_.notify_all();
  return ticket;
}

SharedIndices SortThread::newest() {
  const std::lock_guard lock(mutex_);
  return newest_;
}

SharedIndices SortThread::wait(std::uint64_t ticket) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return newest_ && newest_->ticket >= ticket; });
  return newest_;
}

std::shared_ptr<IndexBuffer> SortThread::free_buffer() {
  for (auto& buffer : pool_)
    if (buffer.use_count() == 1) return buffer;
  // Somebody holds more than one
  auto made = std::make_shared<IndexBuffer>();
  made->indices.resize(sort_.size());
  return made;
}

void SortThread::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return wanted_.has_value() || stops_; });
    if (stops_) return;
    const SortView view = *wanted_;
    const std::uint64_t ticket = last_ticket_;
    wanted_.reset();
    const std::shared_ptr<IndexBuffer> buffer = free_buffer();
    lock.unlock();
    buffer->count = sort_.sort(view, buffer->indices);
    buffer->ticket = ticket;
    lock.lock();
    newest_ = buffer;
    changed_.notify_all();
  }
}

}  // namespace fluxgs::sort
