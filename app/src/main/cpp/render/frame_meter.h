// Counts and times of frames, read from the GPU when it has finished them, so that nobody waits.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "gl/buffer.h"
#include "gl/fence.h"
#include "gl/timestamp.h"

namespace fluxgs::render {

/// GPU time of each stage in milliseconds.
struct FrameTimes {
  double project = 0, sort = 0, draw = 0, resolve = 0;
};

struct FrameStats {
  std::uint32_t drawn = 0;           ///< splats that were not culled
  std::optional<FrameTimes> stages;  ///< when asked for and available
};

/// A ring of the last frames. Not thread-safe; every call with the context current.
class FrameMeter {
 public:
  static constexpr int kStamps = 5;                   ///< before, between and after the four stages
  static constexpr std::size_t kFrames = 3;           ///< a GPU is seldom more behind
  static constexpr std::size_t kBytes = 4 * kFrames;  ///< of the GPU

  static Expected<FrameMeter> create(gl::Api& api, bool timestamps);

  /// A frame begins; it takes the place of the oldest one of the ring.
  void begin();
  /// Records the time at which everything before is finished; the place of a stamp, 0…4.
  void stamp(int place) const;
  /// The frame is enqueued. `count`: its first word is the number of splats drawn.
  void end(const gl::Buffer& count);
  void end(std::uint32_t count);  ///< the same, of a number that is known

  /// The newest frame that is finished and was not spoken of yet.
  Expected<std::optional<FrameStats>> poll();
  /// The last frame, once it is finished; nothing before the first.
  Expected<std::optional<FrameStats>> wait();
  /// Forgets the frames.
  void clear();

 private:
  struct Slot {
    gl::Buffer count;
    std::optional<std::uint32_t> known;  ///< in place of `count`
    std::array<gl::Timestamp, kStamps> stamps;
    gl::Fence fence;
    bool drawn = false;  ///< a frame has ended here
    bool told = false;   ///< and poll() has spoken of it
  };
  void finish(Slot& slot) const;
  Expected<std::optional<FrameStats>> read(Slot& slot) const;
  std::optional<FrameTimes> times_of(const Slot& slot) const;

  gl::Api* api_ = nullptr;
  bool timestamps_ = false;
  std::array<Slot, kFrames> ring_;
  std::size_t last_ = 0;
};

}  // namespace fluxgs::render
