// Reads a scene on a thread of its own, from a file or a pipe of another app.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "fluxgs/io/scene_estimate.h"
#include "viewer/budgeted_reading.h"

namespace fluxgs::viewer {

enum class LoadPhase { idle, reading, decoding, ready, failed, cancelled };

struct LoadState {
  LoadPhase phase = LoadPhase::idle;
  std::uint64_t read = 0, bytes = 0;      ///< of the file; bytes is 0 where the size is not known
  std::optional<SceneEstimate> estimate;  ///< once the header is read, or all of it
  std::string error;                      ///< one line, when it failed
  /// Why, for people: "memory": there is too little, "read": not all of it came, "open": it cannot
  /// be read, "": it is no scene, or damaged.
  std::string problem;
};

/// Loads a scene; where memory runs out that is an error like others.
Expected<LoadedScene> load_or_fail(const std::string& name,
                                   const std::function<Expected<LoadedScene>()>& load);

/// Ends a loading with a scene, which is returned, or with the reason why there is none: an empty
/// scene is one, too.
std::optional<LoadedScene> finish(LoadState& state, Expected<LoadedScene> loaded,
                                  const std::string& name);

struct LoadLimits {
  /// Bytes that the scene as it is drawn may take, together with the file where that is in memory
  /// as a whole: pipes, and formats that are not read in parts. What does not fit stays out
  /// (budgeted_reading.h).
  std::uint64_t memory = std::uint64_t{1} << 31;
  /// Seconds without a byte after which a provider is given up.
  double patience = 30;
  /// Bytes that a provider says there are; for pipes, which cannot be asked themselves.
  std::optional<std::uint64_t> announced = {};
};

/// One scene at a time. All functions are for one thread; none of them waits for the file.
class SceneLoading {
 public:
  SceneLoading() = default;
  ~SceneLoading() { cancel(); }
  SceneLoading(const SceneLoading&) = delete;
  SceneLoading& operator=(const SceneLoading&) = delete;

  /// Begins to read from a file descriptor, which is closed when it is no longer needed: a file, or
  /// a pipe of a provider. An earlier loading is cancelled. `name` is for errors.
  void begin(int descriptor, const std::string& name, const LoadLimits& limits);

  /// Forgets a loading that was begun: its thread ends by itself, as soon as it notices. It does
  /// not while it decodes, and has a DecodeMemoryGuard until then.
  void cancel();

  LoadState state() const;

  /// True if nothing changes any more: there was none, it failed, or the scene was taken.
  bool is_over() const;

  /// The scene, once, when the phase is ready; before that, what has come of it since it was asked
  /// for last (LoadedScene::is_coarse).
  std::optional<LoadedScene> take();

 private:
  struct Job;
  std::shared_ptr<Job> job_;
};

}  // namespace fluxgs::viewer
