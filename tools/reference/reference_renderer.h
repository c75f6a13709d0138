// The reference: volume splatting in float64, written to be obviously right. Brute force, exact
// sort, no tiles, no cut-offs beyond α_min and T_min.
#pragma once

#include <cstdint>
#include <vector>

#include "fluxgs/camera.h"
#include "fluxgs/image.h"
#include "fluxgs/render_options.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs {

struct ReferenceImage {
  Image<double> color;          ///< RGB over the background, not clamped to 1
  Image<double> transmittance;  ///< 1 channel: what is left of the background
};

/// One splat as it meets the image.
struct ReferenceSplat {
  std::uint32_t index;             ///< in the cloud
  double x, y;                     ///< centre, px
  double depth;                    ///< camera z
  double xx, xy, yy;               ///< triangular factor of the conic, see math::Footprint
  double half_width, half_height;  ///< px, the box outside of which α < α_min
  double opacity;                  ///< that of the splat × `compensation`
  double compensation;             ///< κ of a ScreenFilter that compensates, otherwise 1
  double color[3];
  bool clamped[3];  ///< whether the colour was cut at 0
};

/// The splats that can touch the image, nearest first; equal depths in order of index. Splats with
/// non-finite attributes are left out.
std::vector<ReferenceSplat> project_reference(const SplatCloud& cloud, const Camera& camera,
                                              const RenderOptions& options);

/// C = Σ cᵢ αᵢ Tᵢ + T·background with α = min(α_max, o·exp(−½ dᵀΣ⁻¹d)); a splat counts where
/// α ≥ α_min, and a pixel is finished once T < T_min (paper, appendix A).
ReferenceImage render_reference(const SplatCloud& cloud, const Camera& camera,
                                const RenderOptions& options);

/// The colours as a display takes them: limited to 0…1 and rounded to 8 bits.
Image<std::uint8_t> in_bytes(const Image<double>& color);

}  // namespace fluxgs
