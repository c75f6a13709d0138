#include "platform/web/webgpu_device.h"

#include <emscripten.h>

#include <algorithm>
#include <array>
#include <cstdlib>

#include "render/frame_uniforms.h"
#include "render/scaled_camera.h"
#include "render/scene_buffers.h"
#include "render/scene_packing.h"
#include "render/sort_view.h"
#include "render/view_check.h"

namespace fluxgs::web {
namespace {

using render::PackedSplats;

// clang-format off
EM_JS(int, gpu_is_there, (), { return Module['gpu'] && !Module['gpu'].isLost ? 1 : 0; });
EM_JS(int, gpu_is_software, (), { return Module['gpu'].isSoftware ? 1 : 0; });
EM_JS(int, gpu_blends_floats, (), { return Module['gpu'].blendsFloats ? 1 : 0; });
EM_JS(void, gpu_limits, (double* limits), { HEAPF64.set(Module['gpu'].limits, limits / 8); });
EM_JS(void, gpu_make_scene, (size_t count, double geometry_bytes, double coefficient_bytes), {
  Module['gpu'].makeScene(count, geometry_bytes, coefficient_bytes);
});
EM_JS(void, gpu_write, (int coefficients, double offset, const void* bytes, size_t count), {
  Module['gpu'].write(coefficients ? 'coefficients' : 'geometry', offset, HEAPU8.subarray(bytes, bytes + count));
});
EM_JS(void, gpu_make_image, (int width, int height, int is_float), {
  Module['gpu'].makeImage(width, height, !!is_float);
});
EM_JS(void, gpu_drop_image, (), { Module['gpu'].dropImage(); });
EM_JS(void, gpu_drop_scene, (), { Module['gpu'].dropScene(); });
EM_JS(void, gpu_draw, (const void* frame, size_t bytes, int compensated, int key_bits, double red,
                       double green, double blue, int width, int height), {
  Module['gpu'].draw(HEAPU8.subarray(frame, frame + bytes),
                     {compensated: !!compensated, keyBits: key_bits, background: [red, green, blue], width, height});
});
EM_JS(void, gpu_show, (), { Module['gpu'].show(); });
EM_JS(int, gpu_take_drawn, (), { return Module['gpu'].takeDrawn(); });
/// RGBA in memory of malloc(), its width and height in `size`; null where there is no memory.
EM_JS(void*, gpu_read, (int longest, int* size), {
  const image = Module['gpu'].read(longest), at = _malloc(image.data.length);
  if (!at) return 0;
  HEAPU8.set(image.data, at);
  HEAPU32[size >> 2] = image.width;
  HEAPU32[(size >> 2) + 1] = image.height;
  return at;
});
// clang-format on

class WebGpuSceneRenderer final : public render::SceneRenderer {
 public:
  WebGpuSceneRenderer(const render::RendererSettings& settings, std::uint64_t max_buffer_bytes)
      : settings_(settings), max_buffer_bytes_(max_buffer_bytes) {
    settings_.sorter = render::SorterKind::gpu_radix;
    settings_.timestamps = false;
  }
  ~WebGpuSceneRenderer() override {
    gpu_drop_image();
    gpu_drop_scene();
  }

  const render::RendererSettings& settings() const override { return settings_; }
  Expected<void> set_approximation(const render::ApproximationSettings& approximation) override {
    if (auto ok = render::check_approximation(approximation); !ok) return ok;
    settings_.approximation = approximation;
    return {};
  }
  void wait_for_sorts(bool) override {}  // every frame has its own order
  void measure(bool) override {}

  Expected<void> upload(const render::RenderCloud& cloud,
                        std::optional<std::span<const std::uint32_t>> splats,
                        int max_sh_degree) override;
  std::size_t undrawable() const override { return undrawable_; }

  Expected<void> make_image(const render::TargetPlan& plan) override {
    image_ = {plan.width, plan.height, plan.width, plan.height};
    gpu_make_image(plan.width, plan.height,
                   plan.accumulation == render::Accumulation::single_float ? 1 : 0);
    return {};
  }
  void drop_image() override { gpu_drop_image(); }
  render::ImageSize image_size() const override { return image_; }
  void set_scale(double scale) override {
    image_.blend_width = render::scaled_size(image_.width, scale);
    image_.blend_height = render::scaled_size(image_.height, scale);
  }

  Expected<void> draw(const Camera& camera, const RenderOptions& asked) override;
  void fill(const Image<std::uint8_t>&) override {}  // nothing else draws in a page
  void show(int, int) const override { gpu_show(); }
  Expected<Image<std::uint8_t>> read(int longest) const override;

  bool order_is_current() const override { return true; }
  void sort_anew() override {}
  double sort_latency() const override { return 0; }
  Expected<render::FrameStats> stats() override {
    const auto finished = finished_stats();
    if (finished && *finished) return **finished;
    return fail("WebGPU", "frame", "is not finished");  // and a page must not wait
  }
  Expected<std::optional<render::FrameStats>> finished_stats() override {
    const int drawn = gpu_take_drawn();
    if (drawn < 0) return std::nullopt;
    return render::FrameStats{.drawn = static_cast<std::uint32_t>(drawn), .stages = {}};
  }

 private:
  render::RendererSettings settings_;
  std::uint64_t max_buffer_bytes_;
  render::SceneConstants scene_;
  std::size_t undrawable_ = 0;
  render::ImageSize image_;
};

Expected<void> WebGpuSceneRenderer::upload(const render::RenderCloud& cloud,
                                           std::optional<std::span<const std::uint32_t>> splats,
                                           int max_sh_degree) {
  if (auto ok = render::check_cloud(cloud); !ok) return ok;
  render::ScenePacker packer(cloud, splats, max_sh_degree);
  const std::uint64_t geometry = render::kGeometryBytes * packer.constants().count;
  const std::uint64_t coefficients = render::sh_bytes(packer.degrees());
  scene_ = {};
  if (std::max(geometry, coefficients) > max_buffer_bytes_)
    return fail("scene", "size", "too many splats for this browser's WebGPU");
  undrawable_ = packer.undrawable();
  gpu_make_scene(packer.constants().count, static_cast<double>(geometry),
                 static_cast<double>(coefficients));
  double geometry_written = 0, coefficients_written = 0;
  const auto write = [](int buffer, double& written, const auto& values) {
    const std::size_t bytes = sizeof(values[0]) * values.size();
    if (bytes > 0) gpu_write(buffer, written, values.data(), bytes);
    written += static_cast<double>(bytes);
  };
  render::pack_in_parts(packer, nullptr, [&](const PackedSplats& part) {
    write(0, geometry_written, part.geometry);
    write(1, coefficients_written, part.sh);
  });
  scene_ = packer.constants();
  return {};
}

Expected<void> WebGpuSceneRenderer::draw(const Camera& camera, const RenderOptions& asked) {
  const RenderOptions options = for_scene(asked, scene_.filter);
  if (auto ok = render::check_view(camera, options); !ok) return ok;
  const Camera view = render::scaled_camera(camera, image_.blend_width, image_.blend_height);
  const sort::DepthKeys keys =
      render::sort_view(camera, options.near_plane, scene_, settings_.approximation.key_bits).keys;
  const render::FrameUniforms frame =
      render::make_frame_uniforms(view, options, settings_.approximation, scene_, keys);
  const glm::dvec3& b = options.background;
  gpu_draw(&frame, sizeof frame, options.filter->compensated ? 1 : 0, keys.bits, b.r, b.g, b.b,
           image_.blend_width, image_.blend_height);
  return {};
}

Expected<Image<std::uint8_t>> WebGpuSceneRenderer::read(int longest) const {
  std::array<int, 2> size{};
  void* const pixels = gpu_read(longest, size.data());
  if (pixels == nullptr) return fail("image", "memory", "there is none for it");
  Image<std::uint8_t> image(size[0], size[1], 4);
  std::copy_n(static_cast<const std::uint8_t*>(pixels), image.pixels.size(), image.pixels.begin());
  std::free(pixels);
  return image;
}

}  // namespace

bool WebGpuDevice::is_there() { return gpu_is_there() != 0; }

WebGpuDevice::WebGpuDevice() {
  std::array<double, 3> limits{};
  gpu_limits(limits.data());
  limits_ = {.image_side = static_cast<int>(limits[0]),
             .buffer_bytes = static_cast<std::uint64_t>(limits[1]),
             .splats = static_cast<std::uint64_t>(limits[2])};
  quirks_.runs_on_cpu = gpu_is_software() != 0;
}

std::vector<render::Accumulation> WebGpuDevice::accumulations() const {
  using enum render::Accumulation;
  if (gpu_blends_floats() != 0) return {single_float, half_float};
  return {half_float};
}

std::uint64_t WebGpuDevice::max_splats(const DegreeCounts& scene) const {
  return std::min({limits_.buffer_bytes / render::kGeometryBytes, limits_.splats,
                   render::with_sh_in(limits_.buffer_bytes, scene)});
}

Expected<std::unique_ptr<render::SceneRenderer>> WebGpuDevice::make_renderer(
    const render::RendererSettings& settings) {
  return std::make_unique<WebGpuSceneRenderer>(settings, limits_.buffer_bytes);
}

}  // namespace fluxgs::web
