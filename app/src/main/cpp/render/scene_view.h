// A scene in pictures of any size, for programs that go on whatever the driver does: where memory
// is short it shows fewer splats, and when the context was lost all of it is made again.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "fluxgs/splat_cloud.h"
#include "render/memory_estimate.h"
#include "render/render_target.h"
#include "render/renderer.h"

namespace fluxgs::render {

struct SceneViewSettings {
  RendererSettings renderer = {};
  TargetFormat format = TargetFormat::rgba8;
  std::optional<Accumulation> accumulation = {};  ///< not given: accurate_accumulation()
  double scale = 1;  ///< of the picture that is blended, see RenderTarget
  /// Bytes that the scene, its frames and the picture may take together (memory_estimate.h).
  /// Not given: what the driver has.
  std::optional<std::size_t> memory = {};
};

/// Not thread-safe; every call on the thread on which the context is current. When a call fails and
/// gl::context_lost() says so: make a new context, then open() in it.
class SceneView {
 public:
  /// The cloud is kept, as the scene must be made from it again and again.
  SceneView(std::shared_ptr<const SplatCloud> cloud, const SceneViewSettings& settings)
      : cloud_(std::move(cloud)), settings_(settings) {}

  /// Makes the GL objects for pictures of this size. What an earlier open() made is let go of
  /// first, so its context must be current, or lost; its Api must still be there. Fails as
  /// Renderer::create() does, and where memory does not even hold a picture and one splat.
  Expected<void> open(gl::Api& api, int width, int height);

  /// Enqueues a frame of the camera's size. Another size than the last one means a new picture and,
  /// where memory is short, another number of splats. Fails as Renderer::draw() does, and when the
  /// context is lost.
  Expected<void> draw(const Camera& camera, const RenderOptions& options);

  /// Lets go of all GL objects.
  void close();

  /// How many splats there are memory for: those that contribute most (splat_budget.h).
  std::size_t splats() const { return shown_; }
  bool shows_all() const { return shown_ == cloud_->size(); }

  // Preconditions: open() was successful.
  Renderer& renderer() { return *renderer_; }
  const RenderTarget& target() const { return target_; }

 private:
  TargetPlan plan(int width, int height) const;
  Expected<void> fit(int width, int height);
  Expected<void> make(int width, int height, std::size_t splats);
  Expected<std::size_t> splats_for(int width, int height) const;
  Expected<void> upload(std::size_t splats);
  Expected<void> check_context() const;

  std::shared_ptr<const SplatCloud> cloud_;
  SceneViewSettings settings_;
  gl::Api* api_ = nullptr;
  std::unique_ptr<Renderer> renderer_;
  RenderTarget target_;
  std::size_t shown_ = 0;
};

}  // namespace fluxgs::render
