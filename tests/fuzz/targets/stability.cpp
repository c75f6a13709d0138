// Encoding, decoding and encoding again: whatever scene the input is, every writer writes it or
// says why not, every reader reads what was written, and the second generation is the same as the
// first within what each format's quantization allows. For the compact codec:
// compact_stability.cpp.
#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "fluxgs/io/scene.h"
#include "fluxgs/io/spz.h"
#include "harness.h"
#include "io/whole_cloud.h"
#include "scene_of.h"

namespace fluxgs::fuzz {
namespace {

constexpr std::size_t kMaxSplats = 300;  // more show nothing new

/// What may differ between two generations, 0: nothing. Scales: of the logarithm, opacity: 0…1.
struct Tolerance {
  double log_scale = 0, rotation = 0, opacity = 0;
};

struct Writer {
  std::string name;
  Tolerance tolerance;
  Expected<Bytes> (*encode)(const SplatCloud& cloud, const std::string& name, const WriteOptions&);
  std::function<Expected<SceneFile>(Input bytes, const std::string& name)> read;
  /// Chooses codebooks or ranges, and with them an order, anew each time.
  bool adapts = false;
};

// Half a step of three components and what follows for the fourth, see spz.h.
constexpr double kSpzRotation = 0.0025;

Expected<Bytes> encode_spz4(const SplatCloud& cloud, const std::string& name, const WriteOptions&) {
  return encode_spz(cloud, name, SpzOptions{.version = 4, .axes = SpzAxes::right_up_back});
}
Expected<SceneFile> read_spz4(Input bytes, const std::string& name) {
  return read_spz(bytes, name, SpzAxes::right_up_back);
}

Tolerance tolerance_of(std::string_view format) {
  constexpr double kFloat = 1e-5;  // logarithm and back in single precision
  if (format == "ply") return {};
  if (format == "splat") return {.log_scale = kFloat};
  if (format == "spz") return {.rotation = kSpzRotation};
  return {.log_scale = kFloat, .rotation = kFloat, .opacity = kFloat};
}

std::vector<Writer> all_writers() {
  std::vector<Writer> writers{{"spz4", tolerance_of("spz"), encode_spz4, read_spz4}};
  for (const SceneFormat& format : scene_formats()) {
    if (format.encode == nullptr) continue;
    const auto read = [&format](Input bytes, const std::string& name) {
      return io::read_whole(name, [&](SplatSink& sink) {
        return read_scene(format, MemoryBytes(bytes), name, sink);
      });
    };
    writers.push_back({std::string(format.name), tolerance_of(format.name), format.encode, read,
                       format.name == "sog" || format.name == "compressed.ply"});
  }
  return writers;
}

double opacity(float logit) { return 1 / (1 + std::exp(-double{logit})); }

double rotation_difference(const glm::quat& a, const glm::quat& b) {
  if (a == b) return 0;
  const glm::dquat p = glm::normalize(glm::dquat(a)), q = glm::normalize(glm::dquat(b));
  return std::min(glm::length(p - q), glm::length(p + q));
}

void check_same(const SplatCloud& a, const SplatCloud& b, const Writer& writer) {
  const auto require_same = [&](bool same, const char* attribute) {
    if (!same) broken(fmt::format("{}: {} is stable", writer.name, attribute));
  };
  require_same(a.size() == b.size() && a.sh_degree == b.sh_degree, "the number of splats");
  require_same(a.positions == b.positions, "position");
  require_same(a.sh_dc == b.sh_dc, "colour");
  require_same(a.sh_rest == b.sh_rest, "each harmonic");
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const double off = std::abs(double{a.log_scales[i][c]} - double{b.log_scales[i][c]});
      require_same(off <= writer.tolerance.log_scale, "scale");
    }
    require_same(std::abs(opacity(a.opacity_logits[i]) - opacity(b.opacity_logits[i])) <=
                     writer.tolerance.opacity,
                 "opacity");
    require_same(rotation_difference(a.rotations[i], b.rotations[i]) <= writer.tolerance.rotation,
                 "rotation");
  }
}

SplatCloud generation(const Bytes& file, std::size_t splats, const Writer& writer) {
  auto scene = writer.read(file, "x");
  if (!scene) broken(fmt::format("{}: reads its own: {}", writer.name, scene.error().message()));
  check_scene(*scene);
  if (scene->cloud.size() != splats || scene->dropped != 0) {
    broken(fmt::format("{}: keeps {} splats, not {}, dropped {}", writer.name, splats,
                       scene->cloud.size(), scene->dropped));
  }
  return std::move(scene->cloud);
}

void try_writer(const SplatCloud& cloud, const Writer& writer) {
  const auto once = writer.encode(cloud, "x", {});
  if (!once) return check_error(once.error());
  const std::size_t splats = cloud.size() - count_non_finite(cloud);
  const SplatCloud first = generation(*once, splats, writer);
  const auto twice = writer.encode(first, "x", {});
  if (!twice) broken(fmt::format("{}: writes its own: {}", writer.name, twice.error().message()));
  const SplatCloud second = generation(*twice, splats, writer);
  if (!writer.adapts) check_same(first, second, writer);
}

}  // namespace

FLUXGS_FUZZ_TARGET(stability) {
  static const std::vector<Writer> writers = all_writers();
  const auto cloud = scene_of(input, kMaxSplats);
  if (!cloud) return Worth::forget;
  for (const Writer& writer : writers) try_writer(*cloud, writer);
  return Worth::keep;
}

}  // namespace fluxgs::fuzz
