#include "render/scene_view.h"

#include <algorithm>
#include <string>
#include <utility>

#include "gl/expected_chain.h"
#include "render/scaled_camera.h"
#include "render/scene_buffers.h"
#include "render/splat_budget.h"
#include "render/view_check.h"

namespace fluxgs::render {
namespace {

/// As many splats as with harmonics of degree 1, and then the highest degree. `count`: how many
/// there may be with harmonics of a degree.
template <class Count>
std::pair<std::size_t, int> most_splats(int sh_degree, const Count& count) {
  const std::size_t most = count(std::min(sh_degree, 1));
  while (sh_degree > 1 && count(sh_degree) < most) --sh_degree;
  return {most, sh_degree};
}

}  // namespace

Expected<void> SceneView::open(Device& device, int width, int height) {
  close();
  device_ = &device;
  if (auto sound = check_cloud(*cloud_); !sound) return sound;
  degrees_ = settings_.software ? DegreeCounts{} : count_degrees(*cloud_);
  return gl::chain(
      [&] { return gl::assign_or_error(device.make_renderer(settings_.renderer), renderer_); },
      [&] { return fit({width, height}); }, [&] { return check_device(); });
}

Expected<void> SceneView::check_device() const {
  if (!device_->is_lost()) return {};
  return fail("graphics device", "", "the context was lost");
}

void SceneView::set_scale(double scale) { settings_.scale = scale; }

void SceneView::close() {
  planned_ = {};
  fitted_ = {};
  renderer_.reset();
  shown_ = {};
}

Expected<void> SceneView::draw(const Camera& camera, const RenderOptions& options) {
  if (auto ok = check_image_size(camera); !ok) return ok;
  const Size size{camera.width, camera.height};
  if (size != fitted_)
    if (auto fitted = fit(size); !fitted) return fitted;
  renderer_->set_scale(settings_.scale);
  auto drawn =
      settings_.software ? draw_in_software(camera, options) : renderer_->draw(camera, options);
  if (!drawn) return drawn;
  auto whole = check_device();
  if (!whole) renderer_->sort_anew();  // who knows what became of the order
  return whole ? check_first_frames() : whole;
}

Expected<void> SceneView::draw_in_software(const Camera& camera, const RenderOptions& options) {
  if (auto ok = check_view(camera, options); !ok) return ok;
  const ImageSize size = image_size();
  const SoftwareFrame frame =
      settings_.software(scaled_camera(camera, size.blend_width, size.blend_height), options);
  renderer_->fill(frame.image);
  drawn_in_software_ = frame.drawn;
  return {};
}

/// A device that refuses to draw does so from the start; to ask it about every frame takes time.
Expected<void> SceneView::check_first_frames() {
  if (unchecked_frames_ == 0) return {};
  --unchecked_frames_;
  return device_->check_errors("drawing");
}

/// Those that may be used, the most accurate first.
std::vector<Accumulation> SceneView::accumulations() const {
  if (settings_.software) return {Accumulation::direct};  // nothing is blended
  if (settings_.accumulation) return {*settings_.accumulation};
  return device_->accumulations();
}

TargetPlan SceneView::plan(const Size& size, Accumulation accumulation) const {
  return {
      .width = size.width, .height = size.height, .accumulation = accumulation, .for_window = true};
}

bool SceneView::device_has(const Size& size) const {
  return size.width <= device_->max_image_width() && size.height <= device_->max_image_height();
}

// By the estimate; whether the device has as much is seen when it is asked.
bool SceneView::fits_with_all(const TargetPlan& image) const {
  return !settings_.memory ||
         estimate_memory(degrees_of(asked()), renderer_->settings(), image).total() <=
             *settings_.memory;
}

bool SceneView::fits_half(const TargetPlan& image) const {
  return estimate_memory({}, {}, image).targets <= *settings_.memory / 2 &&
         amount_for(image).count > 0;
}

std::optional<TargetPlan> SceneView::image_of(const Size& size) const {
  if (!device_has(size)) return std::nullopt;
  for (const Accumulation a : accumulations())
    if (const TargetPlan image = plan(size, a); fits_with_all(image)) return image;
  const TargetPlan least = plan(size, accumulations().back());
  return fits_half(least) ? std::optional(least) : std::nullopt;
}

Expected<TargetPlan> SceneView::image_for(Size size) const {
  for (;; size = size.halved()) {
    if (const auto image = image_of(size)) return *image;
    if (size.is_pixel())
      return fail("graphics memory", "",
                  std::to_string(*settings_.memory) + " bytes do not hold one pixel and one splat");
  }
}

/// Whichever splats they are, they are no more than these.
DegreeCounts SceneView::degrees_of(const Amount& amount) const {
  return largest_of(limited(degrees_, amount.sh_degree), amount.count);
}

/// And that the device can have.
std::size_t SceneView::splats_asked(int sh_degree) const {
  const std::uint64_t most = device_->max_splats(limited(degrees_, sh_degree));
  return static_cast<std::size_t>(
      std::min<std::uint64_t>(most, std::min(settings_.max_splats.value_or(~0UL), cloud_->size())));
}

SceneView::Amount SceneView::asked() const {
  if (settings_.software) return {cloud_->size(), cloud_->sh_degree};
  const auto [count, degree] =
      most_splats(cloud_->sh_degree, [&](int d) { return splats_asked(d); });
  return {count, degree};
}

SceneView::Amount SceneView::amount_for(const TargetPlan& image) const {
  if (!settings_.memory || settings_.software) return asked();
  const auto fit = [&](int sh_degree) {
    const auto most = splats_that_fit(*settings_.memory, limited(degrees_, sh_degree),
                                      renderer_->settings(), image);
    return static_cast<std::size_t>(std::min<std::uint64_t>(most, splats_asked(sh_degree)));
  };
  const auto [count, degree] = most_splats(cloud_->sh_degree, fit);
  return {count, degree};
}

std::size_t SceneView::memory() const {
  return estimate_memory(degrees_of(shown_), renderer_->settings(), planned_).taken();
}

bool SceneView::is_reduced() const {
  return shown_ != asked() || Size{planned_.width, planned_.height} != fitted_ ||
         planned_.accumulation != accumulations().front();
}

Expected<void> SceneView::upload(const Amount& amount) {
  if (amount == shown_) return {};
  if (settings_.software) {
    shown_ = amount;
    return {};
  }
  shown_ = {};
  auto uploaded = amount.count == cloud_->size()
                      ? renderer_->upload(*cloud_, {}, amount.sh_degree)
                      : renderer_->upload(*cloud_, max_contributing(cloud_->base, amount.count),
                                          amount.sh_degree);
  if (uploaded) shown_ = amount;
  return uploaded;
}

Expected<void> SceneView::make(const TargetPlan& image, const Amount& amount) {
  // What is there goes first: there may not be room for both
  renderer_->drop_image();
  if (amount != shown_) {
    shown_ = {};
    if (auto emptied = renderer_->upload(RenderCloud()); !emptied) return emptied;
  }
  planned_ = image;
  return gl::chain([&] { return make_image(); }, [&] { return upload(amount); },
                   // Some drivers notice late
                   [&] { return device_->check_errors("graphics memory"); });
}

Expected<void> SceneView::make_image() {
  constexpr int kCheckedFrames = 3;
  unchecked_frames_ = kCheckedFrames;
  return renderer_->make_image(planned_);
}

// As much of the scene as there is room for beside that image.
Expected<void> SceneView::fit_splats(const TargetPlan& image) {
  for (Amount amount = amount_for(image);;) {
    device_->room_was_made();
    auto made = make(image, amount);
    if (made || !device_->is_out_of_memory() || amount.count <= 1) return made;
    if (amount.sh_degree > 1)
      --amount.sh_degree;
    else
      amount.count -= (amount.count + 3) / 4;
  }
}

Expected<void> SceneView::fit(const Size& size) {
  fitted_ = {};
  auto image = image_for(size);
  if (!image) return std::unexpected(image.error());
  for (;;) {
    const bool coarser = image->accumulation != accumulations().back();
    device_->room_was_made();
    auto made = coarser ? make(*image, amount_for(*image)) : fit_splats(*image);
    if (made) fitted_ = size;
    const Size tried{image->width, image->height};
    if (made || !device_->is_out_of_memory() || device_->is_lost()) return made;
    if (!coarser && tried.is_pixel()) return made;
    image = plan(coarser ? tried : tried.halved(), accumulations().back());
  }
}

}  // namespace fluxgs::render
