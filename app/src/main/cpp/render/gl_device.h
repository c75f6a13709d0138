// OpenGL as the device of a viewer.
#pragma once

#include "gl/api.h"
#include "render/device.h"

namespace fluxgs::render {

/// Every call on the thread on which the context of the Api, which must outlive it, is current.
class GlDevice final : public Device {
 public:
  explicit GlDevice(gl::Api& api) : api_(api) {}
  gl::Api& api() const { return api_; }

  const gl::Quirks& quirks() const override { return api_.quirks; }
  /// default_accumulation(), or half floats where there is no room for that.
  std::vector<Accumulation> accumulations() const override;
  int max_image_width() const override;
  int max_image_height() const override;
  std::uint64_t max_splats(const DegreeCounts& scene) const override;
  bool is_lost() override { return gl::context_lost(api_); }
  void lose() override { api_.lost = true; }
  Expected<void> check_errors(const char* where) override { return gl::check_errors(api_, where); }
  bool is_out_of_memory() const override { return api_.out_of_memory; }
  void room_was_made() override { api_.out_of_memory = false; }
  /// Fails as Renderer::create() does.
  Expected<std::unique_ptr<SceneRenderer>> make_renderer(const RendererSettings& settings) override;

 private:
  gl::Api& api_;
};

}  // namespace fluxgs::render
