// Carving: what photos show as transparent stays empty, and what they show is opaque. Each
// iteration has another background, behind the render and behind the photo alike: a splat in an
// empty place, and a hole in an object, have the wrong colour for nearly all of them.
#pragma once

#include <memory>

#include "trainer/data/dataset.h"
#include "trainer/model/phase.h"

namespace fluxgs {

struct MaskOptions {
  static constexpr const char* kTitle = "Masks";
  MaskUse masks = MaskUse::automatic;  ///< of the data set (LoadOptions::masks)

  OptionFields fields(const TrainOptions& all);
};

/// Null where no view is transparent anywhere.
std::unique_ptr<Phase> make_carving(const TrainOptions& options, const std::vector<View>& views);

}  // namespace fluxgs
