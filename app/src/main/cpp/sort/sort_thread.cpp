#include "sort/sort_thread.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace fluxgs::sort {
namespace {

// Splats farther than this from the direction of view are left out: cos 120°. No field of view
// together with the turn of the camera during one sort gets there.
constexpr float kFarthestCosine = -0.5F;

// As the GPU computes it (shaders/project.comp), but for splats behind the camera, which might come
// into view before the next order is ready: those lie in front of all others.
std::uint32_t key_of(const glm::vec3& position, const glm::vec3& centre, const glm::vec3& forward,
                     const DepthKeys& keys) {
  const glm::vec3 ray = position - centre;
  const float depth = glm::dot(forward, ray);
  if (depth > 0) return depth_key(keys, depth);
  const bool near_enough = depth >= kFarthestCosine * glm::length(ray);  // false for NaN
  return near_enough ? 0 : kDropped;
}

}  // namespace

SortThread::SortThread(std::vector<glm::vec3> positions)
    : positions_(std::move(positions)), keys_(positions_.size()), scratch_(positions_.size()) {
  for (auto& buffer : pool_) {
    buffer = std::make_shared<IndexBuffer>();
    buffer->indices.resize(positions_.size());
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

SharedIndices SortThread::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

SharedIndices SortThread::wait(std::uint64_t ticket) const {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return newest_ && newest_->ticket >= ticket; });
  return newest_;
}

std::shared_ptr<IndexBuffer> SortThread::free_buffer() {
  for (auto& buffer : pool_)
    if (buffer.use_count() == 1) return buffer;
  // Somebody holds more than one
  auto made = std::make_shared<IndexBuffer>();
  made->indices.resize(positions_.size());
  return made;
}

void SortThread::sort(const SortView& view, IndexBuffer& into) {
  const glm::vec3 centre(view.centre), forward(view.forward);
  for (std::size_t i = 0; i < positions_.size(); ++i)
    keys_[i] = key_of(positions_[i], centre, forward, view.keys);
  into.count = radix_sort(keys_, view.keys.bits, scratch_, into.indices);
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
    sort(view, *buffer);
    buffer->ticket = ticket;
    lock.lock();
    newest_ = buffer;
    changed_.notify_all();
  }
}

}  // namespace fluxgs::sort
