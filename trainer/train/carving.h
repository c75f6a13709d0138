// Carving: what photos show as transparent stays empty, and what they show is opaque. Each
// iteration has another background, behind the render and behind the photo alike: a splat in an
// empty place, and a hole in an object, have the wrong colour for nearly all of them. Faint splats
// hardly differ from any, so that the loss also has the difference of opacities.
#pragma once

#include <cstdint>
#include <memory>

#include "fluxgs/image.h"
#include "trainer/core/planar_image.h"
#include "trainer/data/dataset.h"
#include "trainer/model/phase.h"

namespace fluxgs {

struct MaskOptions {
  static constexpr const char* kTitle = "Masks";
  MaskUse masks = MaskUse::automatic;  ///< of the data set (LoadOptions::masks)
  /// Weight of the mean of |A − α|, A the render's opacity at a pixel and α the photo's.
  double alpha_loss = 0.1;

  OptionFields fields(const TrainOptions& all);
};

/// The derivative of weight·mean |1 − T − α/255| by the transmittances T (1 channel), 0 where both
/// are the same to 8 bits and where `used` (as alpha; may be empty) is 0. `out` is made anew if its
/// size differs.
void alpha_loss_gradient(const PlanarImage& transmittance, const Image<std::uint8_t>& alpha,
                         const Image<std::uint8_t>& used, double weight, const Threads& threads,
                         PlanarImage& out);

/// Null where no view is transparent anywhere.
std::unique_ptr<Phase> make_carving(const TrainOptions& options, const std::vector<View>& views);

}  // namespace fluxgs
