#include "viewer/scene_loading.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <exception>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "fluxgs/byte_source.h"
#include "fluxgs/io/scene.h"
#include "viewer/decode_memory_guard.h"

namespace fluxgs::viewer {
namespace {

using Bytes = std::vector<std::byte>;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kChunk = std::size_t{1} << 20;
constexpr int kLookEveryMs = 100;  // whether it was cancelled
constexpr std::size_t kEnoughForHeaders = std::size_t{1} << 16;

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

/// State that the thread and the owner share.
struct SceneLoading::Job {
  int descriptor = -1;
  std::string name;
  LoadLimits limits;
  std::atomic<bool> cancelled = false;
  mutable std::mutex mutex;
  LoadState state;
  std::optional<Clock::time_point> last_came;  ///< bytes, or the wish for the first
  std::optional<LoadedScene> scene;

  /// A file that says how far it has been read, and ends when the loading is cancelled.
  class WatchedFile final : public ByteSource {
   public:
    WatchedFile(Job& job, std::uint64_t begin, std::uint64_t size)
        : job_(job), bytes_(job.descriptor, begin, size, job.name) {}
    std::uint64_t size() const override { return bytes_.size(); }
    Expected<std::span<const std::byte>> read(std::uint64_t at, std::size_t count,
                                              Bytes& room) const override {
      if (job_.cancelled) return fail(job_.name, "read", "was cancelled");
      auto part = bytes_.read(at, count, room);
      job_.came();
      if (part) job_.update([&](LoadState& s) { s.read = std::max(s.read, at + count); });
      return part;
    }

   private:
    Job& job_;
    FileBytes bytes_;
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

  void came() {
    const std::lock_guard lock(mutex);
    last_came = Clock::now();
  }

  /// A file of which nothing has come for too long is given up, even where the thread hangs in a
  /// read(): what is said to be a regular file may be another app's, or lie across a network.
  void look_for_stalling() {
    const std::lock_guard lock(mutex);
    if (state.phase != LoadPhase::reading || !last_came) return;
    if (std::chrono::duration<double>(Clock::now() - *last_came).count() <= limits.patience) return;
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

  /// All bytes, of which there are so many where that is known.
  Expected<Bytes> read_all(const std::optional<std::uint64_t>& size) {
    if (size && *size > limits.memory) return too_large(*size);
    Bytes bytes;
    if (size) bytes.reserve(*size + kChunk);  // the last read asks for more than there is
    came();
    while (!cancelled) {
      const auto there = wait_for_bytes();
      if (!there) return std::unexpected(there.error());
      if (!*there) break;
      const std::size_t before = bytes.size();
      make_room(bytes);
      bytes.resize(before + kChunk);
      const auto got = ::read(descriptor, bytes.data() + before, kChunk);
      came();
      bytes.resize(before + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
      if (got < 0 && (errno == EINTR || errno == EAGAIN)) continue;
      if (got < 0) return fail(name, "read", std::generic_category().message(errno));
      if (got == 0) break;
      if (bytes.size() > limits.memory) return too_large(bytes.size());
      if (before < kEnoughForHeaders && bytes.size() >= kEnoughForHeaders)
        if (auto fits = look_ahead(bytes, size); !fits) return std::unexpected(fits.error());
      update([&](LoadState& s) { s.read = bytes.size(); });
    }
    // A .splat has no header that would miss the rest
    if (!cancelled && size && bytes.size() < *size)
      return fail(
          name, "read",
          fmt::format("ended after {} of {} bytes: it was cut, or is gone", bytes.size(), *size));
    return bytes;
  }

  /// For another chunk. Growing takes what there is and the new block at once: together never more
  /// than twice what the scene may take.
  void make_room(Bytes& bytes) const {
    const std::size_t needed = bytes.size() + kChunk;
    if (needed > bytes.capacity())
      bytes.reserve(std::max(needed, std::min<std::size_t>(2 * bytes.size(), limits.memory)));
  }

  /// Memory that it will take at least, for most formats known long before all of it is there: all
  /// splats of what does not lie in a file should fit. Fails if that is too much, and on what is no
  /// scene.
  Expected<void> look_ahead(const Bytes& bytes, const std::optional<std::uint64_t>& size) {
    if (auto known = recognise_beginning(bytes, name); !known)
      return std::unexpected(known.error());
    auto estimate = estimate_beginning(bytes, size.value_or(kUnknownSize), name);
    if (!estimate) return {};
    const int least_degree = std::min(estimate->sh_degree, 1);
    estimate->decoded = estimate->splats * render::render_cloud_bytes(least_degree);
    const std::uint64_t needed = size.value_or(bytes.size()) + estimate->decoded;
    if (needed > limits.memory) return too_large(needed);
    update([&](LoadState& s) { s.estimate = *estimate; });
    return {};
  }

  /// A file of a format that is read in parts.
  const SceneFormat* format_in_parts(const ByteSource& file) const {
    Bytes room;
    const auto most = std::min<std::uint64_t>(file.size(), kEnoughForHeaders);
    const auto begin = file.read(0, static_cast<std::size_t>(most), room);
    if (!begin) return nullptr;
    const auto format = recognise_beginning(*begin, name);
    return format && (*format)->reads_parts ? *format : nullptr;
  }

  /// Has a guard from when memory is taken for the scene.
  Expected<LoadedScene> load(std::optional<DecodeMemoryGuard>& guard) {
    const auto in_file = file_size();
    if (!in_file) return std::unexpected(in_file.error());
    const auto size = *in_file ? *in_file : limits.announced;
    update([&](LoadState& s) { s.bytes = size.value_or(0); });
    if (*in_file) {
      const auto begin = static_cast<std::uint64_t>(position());
      if (const SceneFormat* format = format_in_parts(FileBytes(descriptor, begin, *size, name))) {
        guard.emplace();
        came();
        return decode(*format, WatchedFile(*this, begin, *size), limits.memory);
      }
    }
    const auto bytes = read_all(size);
    if (!bytes) return std::unexpected(bytes.error());
    if (cancelled) return LoadedScene{};
    guard.emplace();
    const auto format = recognise_scene(*bytes, name);
    if (!format) return std::unexpected(format.error());
    start_decoding();
    return decode(**format, MemoryBytes(*bytes), limits.memory - bytes->size());
  }

  void start_decoding() {
    update([](LoadState& s) { s.phase = LoadPhase::decoding; });
  }

  Expected<LoadedScene> decode(const SceneFormat& format, const ByteSource& source,
                               std::uint64_t memory) {
    return read_within(
        memory, format, source, name,
        [&](const SceneEstimate& planned) { update([&](LoadState& s) { s.estimate = planned; }); },
        [&] { start_decoding(); });
  }

  void finish(Expected<LoadedScene> loaded) {
    update([&](LoadState& s) {
      if (s.phase == LoadPhase::failed) return;  // was given up
      if (cancelled) {
        s.phase = LoadPhase::cancelled;
      } else if (!loaded) {
        set_failed(s, loaded.error());
      } else if (loaded->cloud.size() == 0) {
        set_failed(s, fail(name, "", "the scene is empty; expected splats").error());
      } else {
        s.phase = LoadPhase::ready;
        scene = std::move(*loaded);
      }
    });
  }

  void run(std::optional<DecodeMemoryGuard>& guard) {
    try {
      finish(load(guard));
    } catch (const std::exception& problem) {  // of memory
      finish(
          fail(name, "memory", fmt::format("not enough to open the scene ({})", problem.what())));
    }
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
  if (job_->state.phase != LoadPhase::ready) return std::nullopt;
  return std::exchange(job_->scene, std::nullopt);
}

}  // namespace fluxgs::viewer
