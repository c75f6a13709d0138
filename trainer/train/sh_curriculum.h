// SH curriculum: training begins with the constant colour alone; the SH degree in use grows by one
// after equal intervals (3DGS).
#pragma once

#include <memory>

#include "trainer/model/phase.h"

namespace fluxgs {

/// A short run finishes the curriculum too: with one degree per 1,000 iterations, 2,000 iterations
/// on a capture of 84 views at 200×149 lose 0.8 dB.
struct ShCurriculumOptions {
  static constexpr const char* kTitle = "SH curriculum";
  int interval = 0;  ///< iterations; 0: an eighth of the run, at most 1,000 (3DGS) and a quarter of
                     ///< the time before the SH reduction

  OptionFields fields(const TrainOptions& all);
};

/// Resolves the options. `degree`: the SH degree that training starts with; `reduced_at`: the
/// iteration of the SH reduction, 0 if there is none. Null for degree 0.
std::unique_ptr<Phase> make_sh_curriculum(TrainOptions& options, int degree, int reduced_at);

}  // namespace fluxgs
