// Progressive resolution: the first iterations train on smaller images, in less time. Later
// iterations correct what those cannot show.
#pragma once

#include <memory>

#include "trainer/data/dataset.h"
#include "trainer/model/phase.h"

namespace fluxgs {

struct ProgressiveResolutionOptions {
  static constexpr const char* kTitle = "Progressive resolution";
  int levels = 0;  ///< 0…4: images are first halved this often, then once less, …
  int until = 0;   ///< iteration of the first full size; 0: 3/10 of the run

  OptionFields fields(const TrainOptions& all);
};

/// Resolves the options. Null where images are never halved. `views`: the training views, which
/// must outlive the phase.
std::unique_ptr<Phase> make_progressive_resolution(TrainOptions& options,
                                                   const std::vector<View>& views);

}  // namespace fluxgs
