// The renderers that a sub-command can choose from, behind one call.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "fluxgs/splat_cloud.h"
#include "render/renderer.h"
#include "render/scene_view.h"
#include "trainer/train/evaluate.h"

namespace fluxgs::cli {

/// EGL, or ANGLE where a system has no EGL.
inline constexpr char kAnyGl[] = "auto";
inline constexpr char kAnyRenderer[] = "auto";

struct RendererChoice {
  /// auto, gles, cpu (the trainer's own) or reference (float64). auto: gles on a GPU; where OpenGL
  /// runs on the processor as well, or there is none, cpu, which is several times faster there.
  std::string renderer = kAnyRenderer;
  std::string gl = kAnyGl;       ///< for gles: auto, egl, osmesa or angle
  std::string format = "rgba8";  ///< image format of gles: rgba8 or rgba16f
};

inline const std::vector<std::string> kRendererNames = {kAnyRenderer, "gles", "cpu", "reference"};
inline const std::vector<std::string> kGlNames = {"egl", "osmesa", "angle"};
inline const std::vector<std::string> kFormatNames = {"rgba8", "rgba16f"};

/// --renderer and --gl, with the choice's present values as defaults.
void add_renderer_options(CLI::App& command, RendererChoice& choice);

/// The renderer that kAnyRenderer is on this machine.
std::string renderer_for(const RendererChoice& choice);

/// The cpu renderer, for viewers. `threads` must outlive it.
render::SoftwareRenderer software_renderer(const SplatCloud& cloud, const Threads& threads);

/// A renderer with the scene loaded. `threads` must outlive it. Errors: no such GL implementation
/// on this machine, or a scene too large for it.
Expected<ViewRenderer> make_renderer(const RendererChoice& choice, const SplatCloud& cloud,
                                     const RenderOptions& options, const Threads& threads);

/// Says so where splats of the scene are too large or too far for the renderer.
void warn_of_undrawable(const render::Renderer& renderer);
void warn_of_undrawable(std::size_t undrawable, std::size_t splats);

}  // namespace fluxgs::cli
