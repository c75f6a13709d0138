// WebGPU as the device of a viewer. The page makes it (web/webgpu/gpu.js, Module.gpu) before the
// module starts, as that takes time. Errors come late there: it then counts as lost, and what is
// asked of it changes nothing.
#pragma once

#include "render/device.h"

namespace fluxgs::web {

class WebGpuDevice final : public render::Device {
 public:
  /// True if the page has one.
  static bool is_there();

  /// Precondition: is_there().
  WebGpuDevice();

  const gl::Quirks& quirks() const override { return quirks_; }
  std::vector<render::Accumulation> accumulations() const override;
  int max_image_width() const override { return limits_.image_side; }
  int max_image_height() const override { return limits_.image_side; }
  std::uint64_t max_splats(const DegreeCounts& scene) const override;
  bool is_lost() override { return lost_ || !is_there(); }
  void lose() override { lost_ = true; }
  Expected<void> check_errors(const char*) override { return {}; }
  bool is_out_of_memory() const override { return false; }
  void room_was_made() override {}
  Expected<std::unique_ptr<render::SceneRenderer>> make_renderer(
      const render::RendererSettings& settings) override;

 private:
  struct Limits {
    int image_side = 0;              ///< px
    std::uint64_t buffer_bytes = 0;  ///< that a shader sees
    std::uint64_t splats = 0;        ///< of a dispatch
  };
  gl::Quirks quirks_;
  Limits limits_;
  bool lost_ = false;
};

}  // namespace fluxgs::web
