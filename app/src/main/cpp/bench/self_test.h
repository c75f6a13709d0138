// Self-test: values computed from a scene that must be the same on every processor. Finds
// compilers, C libraries and cores that compute differently.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "fluxgs/error.h"
#include "render/render_cloud.h"

namespace fluxgs::bench {

struct SelfTest {
  std::size_t splats = 0;
  std::uint64_t decoded = 0;    ///< hash of every attribute's bits
  std::uint64_t sorted = 0;     ///< of the orders that the CPU's sorter finds, on its thread
  std::uint64_t projected = 0;  ///< of the projections in float32, as shaders compute them
  bool operator==(const SelfTest&) const = default;
};

/// Three views are sorted and projected. The cloud as it is drawn: see put_in_order().
SelfTest self_test(const render::RenderCloud& cloud);

/// One JSON object: splats, decoded, sorted, projected (hashes as 16 hexadecimal digits).
std::string to_json(const SelfTest& result);

}  // namespace fluxgs::bench

extern "C" {
/// For callers without C++: reads a scene from memory, tests, and writes the JSON of the result, or
/// {"error": "…"}, to `json`, 0 at its end. Returns the length of the whole text, which is cut to
/// `room` bytes.
__attribute__((visibility("default"))) std::size_t fluxgs_self_test(const std::uint8_t* scene,
                                                                    std::size_t bytes, char* json,
                                                                    std::size_t room);
}
