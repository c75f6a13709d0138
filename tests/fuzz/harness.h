// The list of fuzz targets, and the promises that every reader of bytes from a
// stranger makes (CONTRIBUTING.md, "Fuzzing"). A promise that is broken ends the program.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/io/scene_file.h"

namespace fluxgs::fuzz {

using Bytes = std::vector<std::byte>;
using Input = std::span<const std::byte>;

/// Whether a fuzzer should build on an input. Those that are legal but slow it had better forget.
enum class Worth { keep, forget };

struct Target {
  const char* name;
  Worth (*run)(Input input);
};

/// Those that are linked in. A program of libFuzzer has one, that of the tests has all.
std::vector<Target>& targets();

struct Registration {
  Registration(const char* name, Worth (*run)(Input)) { targets().push_back({name, run}); }
};

/// FLUXGS_FUZZ_TARGET(name) { … } defines a target, a function of `input` that returns a Worth.
#define FLUXGS_FUZZ_TARGET(name)                            \
  static Worth fuzz_##name(Input input);                    \
  static const Registration add_##name(#name, fuzz_##name); \
  static Worth fuzz_##name(Input input)

/// Prints what was promised and aborts.
[[noreturn]] void broken(std::string_view promise);

inline void require(bool kept, std::string_view promise) {
  if (!kept) broken(promise);
}

/// The most that a reader may hold at once beside its input: `fixed` + `per_byte` for each byte of
/// input, and for a scene that it accepts twice what the scene takes (unpacked, then as a cloud).
struct Allowance {
  std::size_t fixed, per_byte;
};

/// Measures allocations from its construction on where a sanitizer is there to tell (peak() is 0
/// without). One at a time.
class Meter {
 public:
  Meter();
  ~Meter();
  Meter(const Meter&) = delete;
  Meter& operator=(const Meter&) = delete;
  std::size_t peak() const;
};

/// One line of printable text of a length that a person would read.
void check_error(const Error& error);

/// Arrays that agree, finite values, and what `fluxgs info` prints about it.
void check_cloud(const SplatCloud& cloud);
void check_scene(const SceneFile& scene);

/// That `peak` is within `allowance` for `input_bytes`; `scene_bytes`: 0 if there is none.
void check_memory(std::size_t peak, const Allowance& allowance, std::size_t input_bytes,
                  std::size_t scene_bytes);

/// Keeps inputs of scenes that take no time.
Worth worth_of(std::size_t splats);

/// Calls `read`, which returns an Expected<SceneFile>, and checks all of the above.
template <class Read>
Worth try_reader(Input input, const Allowance& allowance, Read read) {
  const Meter meter;
  const Expected<SceneFile> scene = read(input);
  const std::size_t peak = meter.peak();
  if (!scene) {
    check_memory(peak, allowance, input.size(), 0);
    check_error(scene.error());
    return Worth::keep;
  }
  const SplatCloud& cloud = scene->cloud;
  const std::size_t splats = cloud.size() + scene->dropped;
  check_memory(peak, allowance, input.size(), splat_memory_bytes(splats, cloud.sh_degree));
  check_scene(*scene);
  return worth_of(splats);
}

/// Takes parameters of a target off the front of its input; zeros once that is used up.
class Parameters {
 public:
  explicit Parameters(Input input) : rest_(input) {}

  std::uint8_t byte() {
    if (rest_.empty()) return 0;
    const auto value = std::to_integer<std::uint8_t>(rest_.front());
    rest_ = rest_.subspan(1);
    return value;
  }
  std::size_t word() {
    const std::size_t low = byte();
    return low | std::size_t{byte()} << 8;
  }
  Input rest() const { return rest_; }

 private:
  Input rest_;
};

}  // namespace fluxgs::fuzz
