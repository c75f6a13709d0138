#include "trainer/train/evaluate.h"

#include <algorithm>

#include "trainer/core/psnr.h"
#include "trainer/data/photo_memory.h"
#include "trainer/loss/photometric.h"

namespace fluxgs {

Expected<Evaluation> evaluate(const std::vector<View>& views, const ViewRenderer& render,
                              const Threads& threads, const ProgressReport& progress) {
  Evaluation result;
  ProgressCounter counter(progress, views.size());
  PhotometricLoss loss(threads);
  PlanarImage target;
  for (const View& view : views) {
    Expected<PlanarImage> image = render(view.camera);
    if (!image) return std::unexpected(image.error());
    limit_to_displayable(*image);
    to_planar(view.rgb, threads, target);
    result.views.push_back({view.camera.name, std::min(psnr(*image, target, view.used), kMaxPsnr),
                            loss.run(*image, target, 0, view.used).ssim});
    result.psnr += result.views.back().psnr / static_cast<double>(views.size());
    result.ssim += result.views.back().ssim / static_cast<double>(views.size());
    let_go(view);
    counter.add_one();
  }
  return result;
}

}  // namespace fluxgs
