#include "render/frame_meter.h"

#include <algorithm>
#include <chrono>

namespace fluxgs::render {

Expected<FrameMeter> FrameMeter::create(gl::Api& api, bool timestamps) {
  FrameMeter meter;
  meter.api_ = &api;
  meter.timestamps_ = timestamps;
  for (Slot& slot : meter.ring_) {
    auto count = gl::Buffer::create(api, sizeof(std::uint32_t), nullptr, GL_STREAM_READ);
    if (!count) return std::unexpected(count.error());
    slot.count = std::move(*count);
    if (timestamps)
      for (gl::Timestamp& stamp : slot.stamps) stamp = gl::Timestamp(api);
  }
  return meter;
}

void FrameMeter::begin() {
  last_ = (last_ + 1) % kFrames;
  ring_[last_].drawn = ring_[last_].told = false;
}

void FrameMeter::stamp(int place) const {
  if (timestamps_) ring_[last_].stamps[static_cast<std::size_t>(place)].record();
}

void FrameMeter::end(const gl::Buffer& count) {
  Slot& slot = ring_[last_];
  slot.known = {};
  gl::memory_barrier(*api_, GL_BUFFER_UPDATE_BARRIER_BIT);
  count.bind(GL_COPY_READ_BUFFER);
  slot.count.bind(GL_COPY_WRITE_BUFFER);
  api_->CopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, sizeof(std::uint32_t));
  finish(slot);
}

void FrameMeter::end(std::uint32_t count) {
  Slot& slot = ring_[last_];
  slot.known = count;
  finish(slot);
}

void FrameMeter::finish(Slot& slot) const {
  slot.fence = gl::Fence(*api_);
  slot.drawn = true;
}

Expected<std::optional<FrameStats>> FrameMeter::poll() {
  for (std::size_t back = 0; back < kFrames; ++back) {
    Slot& slot = ring_[(last_ + kFrames - back) % kFrames];
    if (!slot.drawn || !slot.fence.passed()) continue;
    if (slot.told) break;  // so were those before
    return read(slot);
  }
  return std::nullopt;
}

Expected<std::optional<FrameStats>> FrameMeter::wait() {
  Slot& slot = ring_[last_];
  if (!slot.drawn) return std::nullopt;
  return read(slot);
}

void FrameMeter::clear() {
  for (Slot& slot : ring_) slot.drawn = slot.told = false;
}

/// Waits for the GPU where the frame is not finished.
Expected<std::optional<FrameStats>> FrameMeter::read(Slot& slot) const {
  FrameStats stats;
  if (slot.known) {
    slot.fence.wait(std::chrono::seconds(10));
    stats.drawn = *slot.known;
  } else {
    auto count = slot.count.read_all<std::uint32_t>(1);
    if (!count) return std::unexpected(count.error());
    stats.drawn = count->front();
  }
  if (timestamps_) stats.stages = times_of(slot);
  slot.told = true;
  return stats;
}

std::optional<FrameTimes> FrameMeter::times_of(const Slot& slot) const {
  std::array<double, kStamps> at{};
  const std::uint64_t first = slot.stamps[0].nanoseconds();
  std::ranges::transform(slot.stamps, at.begin(), [first](const gl::Timestamp& stamp) {
    // Signed: a clock that was set back is no time of 500 years
    return 1e-6 * static_cast<double>(static_cast<std::int64_t>(stamp.nanoseconds() - first));
  });
  if (gl::times_are_disjoint(*api_) || !std::ranges::is_sorted(at)) return std::nullopt;
  return FrameTimes{at[1] - at[0], at[2] - at[1], at[3] - at[2], at[4] - at[3]};
}

}  // namespace fluxgs::render
