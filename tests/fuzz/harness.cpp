#include "harness.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <fmt/format.h>

// Offered by AddressSanitizer of gcc and clang; null without it.
extern "C" {
[[gnu::weak]] int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void*,
                                                                              std::size_t),
                                                            void (*on_free)(const volatile void*));
[[gnu::weak]] std::size_t __sanitizer_get_allocated_size(const volatile void* pointer);
}

namespace fluxgs::fuzz {
namespace {

constexpr std::size_t kLongestMessage = 1000;
constexpr std::size_t kQuickSplats = 20000;

// What is alive of what was allocated since the meter began. Memory of before may be freed, too.
bool measuring = false;
std::ptrdiff_t alive = 0, max_alive = 0;

void on_malloc(const volatile void*, std::size_t size) {
  if (!measuring) return;
  alive += static_cast<std::ptrdiff_t>(size);
  max_alive = std::max(max_alive, alive);
}

void on_free(const volatile void* pointer) {
  if (!measuring || pointer == nullptr) return;
  alive -= static_cast<std::ptrdiff_t>(__sanitizer_get_allocated_size(pointer));
}

bool install_hooks() {
  return __sanitizer_install_malloc_and_free_hooks != nullptr &&
         __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free) != 0;
}

bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

}  // namespace

std::vector<Target>& targets() {
  static std::vector<Target> all;
  return all;
}

void broken(std::string_view promise) {
  std::fprintf(stderr, "BROKEN PROMISE: %.*s\n", static_cast<int>(promise.size()), promise.data());
  std::abort();
}

Meter::Meter() {
  static const bool installed = install_hooks();
  alive = max_alive = 0;
  measuring = installed;
}
Meter::~Meter() { measuring = false; }
std::size_t Meter::peak() const { return static_cast<std::size_t>(max_alive); }

void check_error(const Error& error) {
  const std::string message = error.message();
  require(!error.what.empty(), "an error says what was wrong");
  require(std::ranges::none_of(message, is_control),
          "an error is one line of printable text: " + message);
  require(message.size() <= kLongestMessage,
          fmt::format("an error is short, not {} characters: {}...", message.size(),
                      message.substr(0, 200)));
}

void check_cloud(const SplatCloud& cloud) {
  const std::size_t n = cloud.size();
  require(cloud.sh_degree >= 0 && cloud.sh_degree <= 3, "a scene's degree is 0 to 3");
  const std::size_t rest = n * static_cast<std::size_t>(sh_rest_count(cloud.sh_degree));
  require(cloud.log_scales.size() == n && cloud.rotations.size() == n &&
              cloud.opacity_logits.size() == n && cloud.sh_dc.size() == n &&
              cloud.sh_rest.size() == rest,
          "the arrays of a scene agree in size");
  require(count_non_finite(cloud) == 0, "a scene has finite values only");
}

void check_scene(const SceneFile& scene) {
  check_cloud(scene.cloud);
  require(!scene.format.empty(), "a scene names its format");
  require(scene.bytes > 0, "a scene knows the size of its file");
  for (const auto& [attribute, bits] : scene.attribute_bits) {
    require(std::isfinite(bits) && bits >= 0, "bits of an attribute are a number: " + attribute);
  }
  for (const std::string& extension : scene.extensions) {
    require(std::ranges::none_of(extension, is_control), "names of extensions can be printed");
  }
}

void check_memory(std::size_t peak, const Allowance& allowance, std::size_t input_bytes,
                  std::size_t scene_bytes) {
  const std::size_t most = allowance.fixed + allowance.per_byte * input_bytes + 2 * scene_bytes;
  if (peak <= most) return;
  broken(fmt::format("an input of {} bytes (scene: {}) takes at most {} bytes of memory, not {}",
                     input_bytes, scene_bytes, most, peak));
}

Worth worth_of(std::size_t splats) { return splats <= kQuickSplats ? Worth::keep : Worth::forget; }

}  // namespace fluxgs::fuzz
