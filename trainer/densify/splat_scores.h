// How much each splat has to do with errors, seen from several views (paper, "Multi-view
// Alpha-Weighted Error Accumulation").
#pragma once

#include <cstdint>
#include <vector>

#include "trainer/core/parallel.h"
#include "trainer/core/parameters.h"
#include "trainer/data/dataset.h"
#include "trainer/model/options.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {

/// One entry a splat.
struct SplatScores {
  std::vector<float> plus, minus;   ///< S⁺, S⁻: sums over all views, or per pixel (ScoreShare)
  std::vector<float> contribution;  ///< Σ α·T over all pixels of all views
  std::vector<float> pixels;        ///< pixels it contributes to, over all views; 0: never seen
};

/// Renders `views[sampled[0]]`, … and adds up.
SplatScores score_splats(const std::vector<View>& views, const std::vector<std::uint32_t>& sampled,
                         const PlanarFloats& parameters, const RenderOptions& render,
                         const TrainOptions& options, Rasterizer& rasterizer,
                         const Threads& threads);

/// The value that a fraction `quantile` of the splats have at most. ScoreShare::pixel: of those
/// that some view saw. −1 if there are none.
float score_quantile(const std::vector<float>& values, const SplatScores& scores, double quantile,
                     ScoreShare share);

}  // namespace fluxgs
