#include "viewer/scene_loading.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <exception>
#include <limits>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "fluxgs/byte_source.h"
#include "fluxgs/io/gltf.h"
#include "fluxgs/io/scene.h"
#include "viewer/decode_memory_guard.h"

namespace fluxgs::viewer {
namespace {

using Bytes = std::vector<std::byte>;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kChunk = std::size_t{1} << 20;
constexpr int kLookEveryMs = 100;  // whether it was cancelled
constexpr std::size_t kEnoughForHeaders = std::size_t{1} << 16, kEnoughForGlb = 12;

/// Of LoadState.
std::string problem_of(const Error& error) {
  const bool known = error.field == "memory" || error.field == "read" || error.field == "open";
  return known ? error.field : "";
}

void set_failed(LoadState& state, const Error& error) {
  state.phase = LoadPhase::failed;
  state.error = error.message();
  state.problem = problem_of(error);
}

}  // namespace

Expected<LoadedScene> load_or_fail(const std::string& name,
                                   const std::function<Expected<LoadedScene>()>& load) {
  try {
    return load();
  } catch (const std::exception& problem) {  // of memory
    return fail(name, "memory", fmt::format("not enough to open the scene ({})", problem.what()));
  }
}

std::optional<LoadedScene> finish(LoadState& state, Expected<LoadedScene> loaded,
                                  const std::string& name) {
  if (loaded && loaded->cloud.size() == 0)
    loaded = fail(name, "", "the scene is empty; expected splats");
  if (!loaded) {
    set_failed(state, loaded.error());
    return std::nullopt;
  }
  state.phase = LoadPhase::ready;
  return std::move(*loaded);
}

/// State that the thread and the owner share.
struct SceneLoading::Job {
  int descriptor = -1;
  std::string name;
  LoadLimits limits;
  std::atomic<bool> cancelled = false;
  mutable std::mutex mutex;
  LoadState state;
  std::optional<Clock::time_point> waits_since;  ///< for bytes; nothing: it does not
  std::optional<LoadedScene> scene;

  /// A file that says how far it has been read, and ends when the loading is cancelled.
  class WatchedFile final : public ByteSource {
   public:
    WatchedFile(Job& job, std::uint64_t begin, std::uint64_t size)
        : job_(job), bytes_(job.descriptor, begin, size, job.name) {}
    std::uint64_t size() const override { return bytes_.size(); }
    Expected<std::span<const std::byte>> read(std::uint64_t at, std::size_t count,
                                              Bytes& room) const override {
      if (room.size() < count) room.resize(count);
      for (std::size_t done = 0; done < count;) {
        if (job_.cancelled) return job_.was_cancelled();
        const Waiting waiting(job_);
        const auto part = bytes_.read(at + done, std::min(kChunk, count - done), part_);
        if (!part) return part;
        std::ranges::copy(*part, room.begin() + static_cast<std::ptrdiff_t>(done));
        done += part->size();
        job_.came(at + done, size());
      }
      return std::span<const std::byte>(room).first(count);
    }

   private:
    Job& job_;
    FileBytes bytes_;
    mutable Bytes part_;
  };

  /// A pipe, all bytes of which are kept, as they come once.
  class WatchedPipe final : public ByteSource {
   public:
    explicit WatchedPipe(Job& job) : job_(job) {}

    /// Reads until so many bytes are there, or it ends.
    Expected<void> fill(std::size_t wanted) const {
      while (bytes_.size() < wanted && !ended_) {
        const Waiting waiting(job_);
        const auto there = job_.wait_for_bytes();
        if (!there) return std::unexpected(there.error());
        if (!*there) return job_.was_cancelled();
        const auto got = take_part();
        if (!got) return std::unexpected(got.error());
        if (bytes_.size() > job_.limits.memory) return job_.too_large(bytes_.size());
        job_.came(bytes_.size(), size_);
      }
      return {};
    }
    std::span<const std::byte> so_far() const { return bytes_; }
    void set_size(std::uint64_t size) { size_ = size; }
    std::uint64_t size() const override { return size_; }

    Expected<std::span<const std::byte>> read(std::uint64_t at, std::size_t count,
                                              Bytes& room) const override {
      const auto end = static_cast<std::size_t>(at) + count;
      if (job_.cancelled) return job_.was_cancelled();
      if (auto filled = fill(end); !filled) return std::unexpected(filled.error());
      if (bytes_.size() < end) return job_.cut(bytes_.size(), size_);
      const auto part = std::span<const std::byte>(bytes_).subspan(end - count, count);
      if (bytes_.size() >= size_) return part;
      room.assign(part.begin(), part.end());  // they still grow, and move
      return std::span<const std::byte>(room);
    }

   private:
    Expected<void> take_part() const {
      const std::size_t before = bytes_.size();
      make_room();
      bytes_.resize(before + kChunk);
      const auto got = ::read(job_.descriptor, bytes_.data() + before, kChunk);
      bytes_.resize(before + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
      ended_ = got == 0;
      if (got >= 0 || errno == EINTR || errno == EAGAIN) return {};
      return fail(job_.name, "read", std::generic_category().message(errno));
    }

    /// For another part. Growing takes what there is and the new block at once: together never more
    /// than twice what the scene may take.
    void make_room() const {
      const std::size_t needed = bytes_.size() + kChunk;
      if (needed <= bytes_.capacity()) return;
      const std::uint64_t most = std::min(job_.limits.memory, size_ + kChunk);
      bytes_.reserve(
          std::max<std::size_t>(needed, std::min<std::uint64_t>(2 * bytes_.size(), most)));
    }

    Job& job_;
    std::uint64_t size_ = kUnknownSize - kChunk;
    mutable Bytes bytes_;
    mutable bool ended_ = false;
  };

  /// The time during which bytes are waited for.
  class Waiting {
   public:
    explicit Waiting(Job& job) : job_(job) { set(Clock::now()); }
    Waiting(const Waiting&) = delete;
    Waiting& operator=(const Waiting&) = delete;
    ~Waiting() { set(std::nullopt); }

   private:
    void set(std::optional<Clock::time_point> since) {
      const std::lock_guard lock(job_.mutex);
      job_.waits_since = since;
    }
    Job& job_;
  };

  Job() = default;
  Job(const Job&) = delete;
  Job& operator=(const Job&) = delete;
  ~Job() {
    if (descriptor >= 0) ::close(descriptor);
  }

  template <class Change>
  void update(Change&& change) {
    const std::lock_guard lock(mutex);
    change(state);
  }

  std::unexpected<Error> too_large(std::uint64_t needed) const {
    return needs_memory(name, needed, limits.memory);
  }

  std::unexpected<Error> was_cancelled() const { return fail(name, "read", "was cancelled"); }
  std::unexpected<Error> cut(std::uint64_t bytes, std::uint64_t size) const {
    return fail(name, "read",
                fmt::format("ended after {} of {} bytes: it was cut, or is gone", bytes, size));
  }

  void came(std::uint64_t bytes, std::uint64_t all) {
    constexpr std::uint64_t kPadding = 3;  // at the end of a .glb, which nobody asks for
    update([&](LoadState& s) {
      s.read = std::max(s.read, bytes);
      if (s.phase == LoadPhase::reading && bytes + kPadding >= all) s.phase = LoadPhase::decoding;
    });
  }

  /// A file of which nothing has come for too long is given up, even where the thread hangs in a
  /// read(): what is said to be a regular file may be another app's, or lie across a network.
  void look_for_stalling() {
    const std::lock_guard lock(mutex);
    if (state.phase != LoadPhase::reading || !waits_since) return;
    if (std::chrono::duration<double>(Clock::now() - *waits_since).count() <= limits.patience)
      return;
    cancelled = true;
    set_failed(state,
               fail(name, "read",
                    fmt::format("nothing came for {:.0f} s from where it is kept", limits.patience))
                   .error());
  }

  /// False when it was cancelled.
  Expected<bool> wait_for_bytes() const {
    while (!cancelled) {
      pollfd asked{descriptor, POLLIN, 0};
      const int found = ::poll(&asked, 1, kLookEveryMs);
      if (found > 0) return true;
      if (found < 0 && errno != EINTR)
        return fail(name, "read", std::generic_category().message(errno));
    }
    return false;
  }

  /// Size of a regular file from where it is read; nothing for pipes.
  Expected<std::optional<std::uint64_t>> file_size() const {
    struct stat status{};
    if (::fstat(descriptor, &status) != 0)
      return fail(name, "open", std::generic_category().message(errno));
    if (S_ISDIR(status.st_mode)) return fail(name, "open", "is a folder; expected a scene");
    if (!S_ISREG(status.st_mode)) return std::nullopt;
    return static_cast<std::uint64_t>(std::max<off_t>(status.st_size - position(), 0));
  }

  off_t position() const { return std::max<off_t>(::lseek(descriptor, 0, SEEK_CUR), 0); }

  /// Memory that it will take at least, for most formats known long before all of it is there: all
  /// splats of what does not lie in a file should fit. Fails if that is too much, and on what is no
  /// scene.
  Expected<void> look_ahead(std::span<const std::byte> begin, std::uint64_t size) {
    auto estimate = estimate_beginning(begin, size, name);
    if (!estimate) return {};
    const int least_degree = std::min(estimate->sh_degree, 1);
    estimate->decoded = estimate->splats * render::render_cloud_bytes(least_degree);
    const std::uint64_t needed = (size == kUnknownSize ? begin.size() : size) + estimate->decoded;
    if (needed > limits.memory) return too_large(needed);
    update([&](LoadState& s) { s.estimate = *estimate; });
    return {};
  }

  /// The format of a file, from all of its bytes or from the first of more.
  Expected<const SceneFormat*> format_of(std::span<const std::byte> begin) const {
    return begin.size() < kEnoughForHeaders ? recognise_scene(begin, name)
                                            : recognise_beginning(begin, name);
  }

  /// Has a guard from when memory is taken for the scene.
  Expected<LoadedScene> load(std::optional<DecodeMemoryGuard>& guard) {
    const auto in_file = file_size();
    if (!in_file) return std::unexpected(in_file.error());
    return *in_file ? load_file(**in_file, guard) : load_pipe(guard);
  }

  Expected<LoadedScene> load_file(std::uint64_t size, std::optional<DecodeMemoryGuard>& guard) {
    update([&](LoadState& s) { s.bytes = size; });
    const auto begin = static_cast<std::uint64_t>(position());
    Bytes room;
    const auto first =
        FileBytes(descriptor, begin, size, name)
            .read(0, static_cast<std::size_t>(std::min<std::uint64_t>(size, kEnoughForHeaders)),
                  room);
    if (!first) return std::unexpected(first.error());
    const auto format = format_of(*first);
    if (!format) return std::unexpected(format.error());
    if (!(*format)->reads_parts && size > limits.memory) return too_large(size);
    guard.emplace();
    return decode(**format, WatchedFile(*this, begin, size),
                  (*format)->reads_parts ? limits.memory : limits.memory - size);
  }

  /// The size of a .glb is in its header, so that it need not be there as a whole.
  Expected<LoadedScene> load_pipe(std::optional<DecodeMemoryGuard>& guard) {
    update([&](LoadState& s) { s.bytes = limits.announced.value_or(0); });
    if (limits.announced && *limits.announced > limits.memory) return too_large(*limits.announced);
    WatchedPipe pipe(*this);
    if (auto filled = pipe.fill(kEnoughForGlb); !filled) return std::unexpected(filled.error());
    const auto announced = size_of_glb(pipe.so_far());
    if (auto filled = pipe.fill(announced ? kEnoughForGlb : kEnoughForHeaders); !filled)
      return std::unexpected(filled.error());
    const auto format = format_of(pipe.so_far());
    if (!format) return std::unexpected(format.error());
    if (announced) {
      if (*announced > limits.memory) return too_large(*announced);
      pipe.set_size(*announced);
    } else {
      const std::uint64_t size = limits.announced.value_or(kUnknownSize);
      if (auto fits = look_ahead(pipe.so_far(), size); !fits) return std::unexpected(fits.error());
      if (auto filled = pipe.fill(std::numeric_limits<std::size_t>::max()); !filled)
        return std::unexpected(filled.error());
      // A .splat has no header that would miss the rest
      const std::size_t came = pipe.so_far().size();
      if (limits.announced && came < *limits.announced) return cut(came, *limits.announced);
      pipe.set_size(came);
      start_decoding();
    }
    guard.emplace();
    return decode(**format, pipe, limits.memory - pipe.size());
  }

  void start_decoding() {
    update([](LoadState& s) { s.phase = LoadPhase::decoding; });
  }

  Expected<LoadedScene> decode(const SceneFormat& format, const ByteSource& source,
                               std::uint64_t memory) {
    return read_within(
        memory, format, source, name,
        [&](const SceneEstimate& planned) { update([&](LoadState& s) { s.estimate = planned; }); },
        [&] { start_decoding(); },
        [&](LoadedScene&& coarse) { update([&](LoadState&) { scene = std::move(coarse); }); });
  }

  void finish(Expected<LoadedScene> loaded) {
    update([&](LoadState& s) {
      scene.reset();
      if (s.phase == LoadPhase::failed) return;  // was given up
      if (cancelled)
        s.phase = LoadPhase::cancelled;
      else
        scene = viewer::finish(s, std::move(loaded), name);
    });
  }

  void run(std::optional<DecodeMemoryGuard>& guard) {
    finish(load_or_fail(name, [&] { return load(guard); }));
  }
};

void SceneLoading::begin(int descriptor, const std::string& name, const LoadLimits& limits) {
  cancel();
  auto job = std::make_shared<Job>();
  job->descriptor = descriptor;
  job->name = name;
  job->limits = limits;
  job->state.phase = LoadPhase::reading;
  job_ = job;
  // Not waited for: reading from a provider that stalls may take as long as it likes
  try {
    std::thread([job = std::move(job)]() mutable {
      std::optional<DecodeMemoryGuard> guard;
      job->run(guard);
      job.reset();  // with it what nobody wants, before the guard
    }).detach();
  } catch (const std::system_error& problem) {
    job_->finish(fail(name, "thread", problem.what()));
  }
}

void SceneLoading::cancel() {
  if (job_) job_->cancelled = true;
  job_.reset();
}

LoadState SceneLoading::state() const {
  if (!job_) return {};
  job_->look_for_stalling();
  const std::lock_guard lock(job_->mutex);
  return job_->state;
}

bool SceneLoading::is_over() const {
  if (!job_) return true;
  const std::lock_guard lock(job_->mutex);
  const LoadPhase phase = job_->state.phase;
  return phase == LoadPhase::ready ? !job_->scene
                                   : phase != LoadPhase::reading && phase != LoadPhase::decoding;
}

std::optional<LoadedScene> SceneLoading::take() {
  if (!job_) return std::nullopt;
  const std::lock_guard lock(job_->mutex);
  return std::exchange(job_->scene, std::nullopt);
}

}  // namespace fluxgs::viewer
