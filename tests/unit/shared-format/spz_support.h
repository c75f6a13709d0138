// Hand-made SPZ files and the comparison of scenes for the tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <initializer_list>

#include <fmt/format.h>

#include "fluxgs/io/spz.h"
#include "shared-format/src/io/spz/spz_compression.h"
#include "support.h"

namespace fluxgs::test {

inline Bytes raw(std::initializer_list<int> values) {
  Bytes bytes;
  for (const int v : values) bytes.push_back(static_cast<std::byte>(v));
  return bytes;
}

inline Bytes joined(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

inline Bytes gzip(const Bytes& bytes) { return *io::compress_gzip(bytes, "x"); }

/// The 16 bytes that all versions begin with.
inline Bytes spz_header(std::uint32_t version, std::uint32_t count, int degree, int flags = 0,
                        int fractional_bits = 12, int last = 0) {
  Bytes bytes = bytes_of("NGSP");
  append(bytes, version);
  append(bytes, count);
  const Bytes rest = raw({degree, fractional_bits, flags, last});
  bytes.insert(bytes.end(), rest.begin(), rest.end());
  return bytes;
}

/// Version 4 from its attributes; `extensions` stand between header and table.
inline Bytes spz4(std::uint32_t count, int degree, const std::vector<Bytes>& attributes,
                  const Bytes& extensions = {}) {
  Bytes file = spz_header(4, count, degree, extensions.empty() ? 0 : 2, 12,
                          static_cast<int>(attributes.size()));
  append(file, static_cast<std::uint32_t>(32 + extensions.size()));
  file.resize(32);
  file = joined({file, extensions});
  Bytes streams;
  for (const Bytes& attribute : attributes) {
    const Bytes stream = *io::compress_zstd(attribute, "x");
    append(file, std::uint64_t{stream.size()});
    append(file, std::uint64_t{attribute.size()});
    streams = joined({streams, stream});
  }
  return joined({file, streams});
}

/// A record behind the header or the data.
inline Bytes spz_extension(std::uint32_t type, const Bytes& payload) {
  Bytes record;
  append(record, type);
  append(record, static_cast<std::uint32_t>(payload.size()));
  return joined({record, payload});
}

inline Expected<SceneFile> read_as_spz(const Bytes& bytes) { return read_spz(bytes, "test.spz"); }

/// The largest differences between two scenes; rotations are compared as unit quaternions up to
/// their sign.
struct SpzWorst {
  double position = 0, log_scale = 0, rotation = 0, opacity = 0, dc = 0, sh1 = 0, sh_rest = 0;
};

inline SpzWorst spz_compare(const SplatCloud& a, const SplatCloud& b) {
  SpzWorst worst;
  EXPECT_EQ(a.size(), b.size());
  EXPECT_EQ(a.sh_degree, b.sh_degree);
  if (a.size() != b.size() || a.sh_degree != b.sh_degree) return worst;
  const auto raise = [](double& to, const glm::vec3& p, const glm::vec3& q) {
    for (int c = 0; c < 3; ++c) to = std::max(to, std::abs(double{p[c]} - double{q[c]}));
  };
  const auto opacity = [](float logit) { return 1 / (1 + std::exp(-double{logit})); };
  const auto rest = static_cast<std::size_t>(sh_rest_count(a.sh_degree));
  for (std::size_t i = 0; i < a.size(); ++i) {
    raise(worst.position, a.positions[i], b.positions[i]);
    raise(worst.log_scale, a.log_scales[i], b.log_scales[i]);
    raise(worst.dc, a.sh_dc[i], b.sh_dc[i]);
    for (std::size_t k = 0; k < rest; ++k) {
      raise(k < 3 ? worst.sh1 : worst.sh_rest, a.sh_rest[i * rest + k], b.sh_rest[i * rest + k]);
    }
    const glm::dquat p = glm::normalize(glm::dquat(a.rotations[i]));
    const glm::dquat q = glm::normalize(glm::dquat(b.rotations[i]));
    worst.rotation = std::max(worst.rotation, std::min(glm::length(p - q), glm::length(p + q)));
    worst.opacity = std::max(worst.opacity,
                             std::abs(opacity(a.opacity_logits[i]) - opacity(b.opacity_logits[i])));
  }
  return worst;
}

/// Errors that quantization allows, half a step each. Rotation: three components are off by half a
/// step of 1/(511·√2) each; the fourth follows, at worst by three times that where it is the
/// smallest that a largest component can be (1/2).
inline SpzWorst spz_allowed(int fractional_bits = 12, int sh1_bits = 5, int sh_rest_bits = 4) {
  const double step = 0.5 / (511 * std::sqrt(2.0));
  const double tiny = 1e-6;  // single precision
  return {std::ldexp(0.5, -fractional_bits) + tiny,
          1.0 / 32 + tiny,
          step * std::sqrt(3.0 + 9.0) + tiny,
          0.5 / 255 + tiny,
          0.5 / (255 * 0.15) + tiny,
          std::ldexp(1.0, -sh1_bits) + tiny,
          std::ldexp(1.0, -sh_rest_bits) + tiny};
}

inline void expect_within(const char* what, const SpzWorst& w, const SpzWorst& most) {
  std::printf(
      "%s (allowed): position %.1e (%.1e), log-scale %.4f (%.4f), rotation %.1e (%.1e), "
      "opacity %.5f (%.5f), DC %.4f (%.4f), SH1 %.4f (%.4f), SH2-3 %.4f (%.4f)\n",
      what, w.position, most.position, w.log_scale, most.log_scale, w.rotation, most.rotation,
      w.opacity, most.opacity, w.dc, most.dc, w.sh1, most.sh1, w.sh_rest, most.sh_rest);
  EXPECT_LE(w.position, most.position) << what;
  EXPECT_LE(w.log_scale, most.log_scale) << what;
  EXPECT_LE(w.rotation, most.rotation) << what;
  EXPECT_LE(w.opacity, most.opacity) << what;
  EXPECT_LE(w.dc, most.dc) << what;
  EXPECT_LE(w.sh1, most.sh1) << what;
  EXPECT_LE(w.sh_rest, most.sh_rest) << what;
}

/// Random splats inside of what SPZ can hold, so that only rounding is left.
inline SplatCloud spz_cloud(std::size_t count, int degree, std::uint32_t seed = 5) {
  SplatCloud cloud = random_cloud(count, degree, seed, 20);
  const auto limit = [](glm::vec3& v, float least, float most) {
    for (int c = 0; c < 3; ++c) v[c] = std::clamp(v[c], least, most);
  };
  for (glm::vec3& s : cloud.log_scales) limit(s, -10, 5.9f);
  for (glm::vec3& c : cloud.sh_dc) limit(c, -3.3f, 3.3f);
  for (glm::vec3& c : cloud.sh_rest) limit(c, -0.99f, 0.96f);
  return cloud;
}

}  // namespace fluxgs::test
