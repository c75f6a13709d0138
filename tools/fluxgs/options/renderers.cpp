#include "tools/fluxgs/options/renderers.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>

#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "platform/host/host_context.h"
#include "tools/reference/reference_renderer.h"
#include "trainer/core/planar_image.h"

namespace fluxgs::cli {
namespace {

/// The phone's renderer on this machine. Members in the order in which they depend on each other.
struct Gles {
  std::unique_ptr<host::HostContext> context;
  std::unique_ptr<render::Renderer> renderer;
  std::optional<render::RenderTarget> target;
  render::TargetFormat format = render::TargetFormat::rgba8;

  Expected<PlanarImage> image(const Camera& camera, const RenderOptions& options) {
    if (auto current = context->make_current(); !current) return std::unexpected(current.error());
    if (!target || target->width() != camera.width || target->height() != camera.height) {
      auto made = render::RenderTarget::create(context->api(), camera.width, camera.height, format);
      if (!made) return std::unexpected(made.error());
      target = std::move(*made);
    }
    if (auto drawn = renderer->draw(camera, options, *target); !drawn)
      return std::unexpected(drawn.error());
    auto pixels = renderer->read(*target);
    if (!pixels) return std::unexpected(pixels.error());
    return planes_of(*pixels);
  }
};

/// As a window shows it: 8 bits, A = 1 − transmittance.
Image<std::uint8_t> rgba_of(const PlanarImage& color, const PlanarImage& transmittance) {
  const auto byte = [](float value) {
    // Rounded from halves: lround() takes several times as long
    return static_cast<std::uint8_t>(
        (static_cast<unsigned>(510 * std::clamp(value, 0.0f, 1.0f)) + 1) / 2);
  };
  Image<std::uint8_t> image(color.width(), color.height(), 4);
  for (int y = 0; y < image.height; ++y) {
    std::uint8_t* out = image.at(0, y);
    for (int x = 0; x < image.width; ++x, out += 4) {
      for (int c = 0; c < 3; ++c) out[c] = byte(color.row(c, y)[x]);
      out[3] = byte(1 - transmittance.row(0, y)[x]);
    }
  }
  return image;
}

/// EGL, or where a system has none ANGLE, which packages bring along. The error is EGL's.
Expected<std::unique_ptr<host::HostContext>> first_context() {
  auto egl = host::HostContext::create(host::HostGl::egl);
  if (egl) return egl;
  auto angle = host::HostContext::create(host::HostGl::angle);
  return angle ? std::move(angle) : std::move(egl);
}

Expected<std::unique_ptr<host::HostContext>> context_of(const std::string& gl) {
  if (gl == kAnyGl) return first_context();
  const auto implementation = host::parse_host_gl(gl);
  if (!implementation) return std::unexpected(implementation.error());
  return host::HostContext::create(*implementation);
}

Expected<ViewRenderer> make_gles(const RendererChoice& choice, const SplatCloud& cloud,
                                 const RenderOptions& options) {
  const auto gles = std::make_shared<Gles>();
  gles->format =
      choice.format == "rgba16f" ? render::TargetFormat::rgba16f : render::TargetFormat::rgba8;
  auto context = context_of(choice.gl);
  if (!context) return std::unexpected(context.error());
  gles->context = std::move(*context);
  auto renderer = render::Renderer::create(gles->context->api());
  if (!renderer) return std::unexpected(renderer.error());
  gles->renderer = std::move(*renderer);
  if (auto uploaded = gles->renderer->upload(render::cloud_to_draw(SplatCloud(cloud))); !uploaded)
    return std::unexpected(uploaded.error());
  spdlog::info("GL renderer: {}", gles->context->renderer_string());
  warn_of_undrawable(*gles->renderer);
  return [gles, options](const Camera& camera) { return gles->image(camera, options); };
}

}  // namespace

std::string renderer_for(const RendererChoice& choice) {
  if (choice.renderer != kAnyRenderer) return choice.renderer;
  if (choice.gl != kAnyGl || choice.format != "rgba8") return "gles";  // asked for by its options
  const auto context = context_of(choice.gl);
  return context && !(*context)->api().quirks.runs_on_cpu ? "gles" : "cpu";
}

render::SoftwareRenderer software_renderer(const SplatCloud& cloud, const Threads& threads) {
  const auto rasterizer = std::make_shared<CloudRasterizer>(cloud, threads);
  return [=](const Camera& camera, const RenderOptions& options) {
    const Rasterizer& drawn = rasterizer->render(camera, options);
    return render::SoftwareFrame{rgba_of(drawn.color(), drawn.transmittance()),
                                 static_cast<std::uint32_t>(drawn.counts().visible)};
  };
}

void warn_of_undrawable(std::size_t undrawable, std::size_t splats) {
  if (undrawable == 0) return;
  spdlog::warn("warning: {} of {} splats are not drawn: an attribute is beyond 1e15 or not finite",
               undrawable, splats);
}

void warn_of_undrawable(const render::Renderer& renderer) {
  warn_of_undrawable(renderer.undrawable(), renderer.scene().count);
}

void add_renderer_options(CLI::App& command, RendererChoice& choice) {
  std::vector<std::string> gl_names = kGlNames;
  gl_names.emplace_back(kAnyGl);
  command
      .add_option(
          "--renderer", choice.renderer,
          "gles (the phone's), cpu (the trainer's), reference (float64), or auto: gles on a\n"
          "graphics card, else cpu")
      ->check(CLI::IsMember(kRendererNames))
      ->capture_default_str();
  command.add_option("--gl", choice.gl, "for gles: egl, osmesa, angle, or auto: egl, else angle")
      ->check(CLI::IsMember(gl_names))
      ->capture_default_str();
}

Expected<ViewRenderer> make_renderer(const RendererChoice& choice, const SplatCloud& cloud,
                                     const RenderOptions& options, const Threads& threads) {
  const std::string renderer = renderer_for(choice);
  if (renderer == "gles") return make_gles(choice, cloud, options);
  if (renderer == "cpu") return cpu_view_renderer(cloud, options, threads);
  return [cloud, options](const Camera& camera) -> Expected<PlanarImage> {
    return planes_of(render_reference(cloud, camera, options).color);
  };
}

}  // namespace fluxgs::cli
