// How long the sorters take, for every number of keys, key width and digit width.
#include <cmath>
#include <random>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "bench/samples.h"
#include "platform/host/host_context.h"
#include "sort/cpu_radix_sort.h"
#include "sort/gpu_radix_sorter.h"
#include "sort/sort_thread.h"

namespace fluxgs {
namespace {

struct Settings {
  std::string gl = "egl";
  std::vector<std::uint32_t> counts = {10'000, 30'000, 100'000, 300'000, 1'000'000, 2'000'000};
  std::vector<int> key_bits = {16, 20, 24, 32}, digit_bits = {4, 5, 6, 7, 8};
  int repeats = 7;
};

// Depths of splats in a ball around a point three radii away.
std::vector<glm::vec3> positions(std::uint32_t count) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<glm::vec3> all(count);
  for (glm::vec3& p : all) {
    const glm::vec3 v(normal(random), normal(random), normal(random));
    p = v * (std::cbrt(uniform(random)) / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z)) +
        glm::vec3(0, 0, 3);
  }
  return all;
}

std::vector<std::uint32_t> keys_of(const std::vector<glm::vec3>& positions, int bits) {
  const sort::DepthKeys keys = sort::depth_keys(0.01F, 5.0F, bits);
  std::vector<std::uint32_t> all;
  for (const glm::vec3& p : positions) all.push_back(sort::depth_key(keys, p.z));
  return all;
}

template <class Work>
bench::Summary timed(int repeats, Work&& work) {
  work();
  std::vector<double> samples;
  for (int i = 0; i < repeats; ++i) samples.push_back(bench::milliseconds_of(work));
  return bench::summarize(samples);
}

Expected<void> time_gpu(gl::Api& api, const Settings& s, const std::vector<std::uint32_t>& keys,
                        int key_bits) {
  const auto count = static_cast<std::uint32_t>(keys.size());
  const auto source = gl::Buffer::create(api, 4 * keys.size(), keys.data());
  if (!source) return std::unexpected(source.error());
  for (const int digit_bits : s.digit_bits) {
    auto sorter = sort::GpuRadixSorter::create(api, digit_bits);
    if (!sorter) return std::unexpected(sorter.error());
    if (auto room = (*sorter)->set_scene(count, 0, {}); !room) return room;
    const auto ms = timed(s.repeats, [&] {
      (*sorter)->sort_keys(*source, count, key_bits);
      api.Finish();
    });
    fmt::print("{:>9} {:>4} bits  GPU, {}-bit digits {:>9.2f} ms ({:.2f} at least) {:>7.1f} M/s\n",
               count, key_bits, digit_bits, ms.median, ms.least, 1e-3 * count / ms.median);
  }
  return {};
}

void time_cpu(const Settings& s, const std::vector<glm::vec3>& at,
              const std::vector<std::uint32_t>& keys, int key_bits) {
  sort::RadixScratch scratch(keys.size());
  std::vector<std::uint32_t> order(keys.size());
  const auto radix = timed(s.repeats, [&] { sort::radix_sort(keys, key_bits, scratch, order); });
  sort::SortThread thread(at);
  const sort::SortView view{.centre = {0, 0, 0},
                            .forward = {0, 0, 1},
                            .near_plane = 0.01,
                            .keys = sort::depth_keys(0.01F, 5.0F, key_bits)};
  const auto whole = timed(s.repeats, [&] { thread.wait(thread.request(view)); });
  fmt::print(
      "{:>9} {:>4} bits  CPU               {:>9.2f} ms ({:.2f} at least) {:>7.1f} M/s, with keys "
      "and thread {:.2f} ms\n",
      keys.size(), key_bits, radix.median, radix.least,
      1e-3 * static_cast<double>(keys.size()) / radix.median, whole.median);
}

Expected<void> run(const Settings& s) {
  const auto implementation = host::parse_host_gl(s.gl);
  if (!implementation) return std::unexpected(implementation.error());
  const auto context = host::HostContext::create(*implementation);
  if (!context) return std::unexpected(context.error());
  fmt::print("{}\n", (*context)->renderer_string());
  for (const std::uint32_t count : s.counts) {
    const std::vector<glm::vec3> at = positions(count);
    for (const int bits : s.key_bits) {
      const std::vector<std::uint32_t> keys = keys_of(at, bits);
      if (auto ok = time_gpu((*context)->api(), s, keys, bits); !ok) return ok;
      time_cpu(s, at, keys, bits);
    }
  }
  return {};
}

}  // namespace
}  // namespace fluxgs

int main(int argc, char** argv) {
  fluxgs::Settings settings;
  CLI::App app("Times the sorters of the renderer");
  app.footer("Example: sort_benchmark --gl egl --counts 10000,300000 --digits 4,8");
  app.add_option("--counts", settings.counts, "numbers of keys")
      ->delimiter(',')
      ->check(CLI::Range(1U, 100'000'000U));
  app.add_option("--keys", settings.key_bits, "widths of keys, bits")
      ->delimiter(',')
      ->check(CLI::Range(1, 32));
  app.add_option("--digits", settings.digit_bits, "widths of the GPU's digits, bits")
      ->delimiter(',')
      ->check(CLI::Range(4, 8));
  app.add_option("--repeats", settings.repeats, "runs of each")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--gl", settings.gl, "egl, osmesa or angle")
      ->check(CLI::IsMember({"egl", "osmesa", "angle"}))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const auto done = fluxgs::run(settings);
  if (!done) spdlog::error("{}", done.error().message());
  return done ? 0 : 1;
}
