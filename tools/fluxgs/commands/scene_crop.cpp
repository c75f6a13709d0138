#include "tools/fluxgs/commands/scene_crop.h"

#include <cmath>
#include <cstdint>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <glm/geometric.hpp>

#include "tools/fluxgs/options/data_options.h"

namespace fluxgs::cli {
namespace {

constexpr double kFarthest = 1e12;

/// True if a splat is within all limits.
class Keep {
 public:
  explicit Keep(const CropOptions& options)
      : options_(options),
        least_logit_(std::log(options.min_opacity) - std::log1p(-options.min_opacity)) {}

  bool operator()(const SplatCloud& cloud, std::size_t i) const {
    const glm::dvec3 center(cloud.positions[i]);
    return in_box(center) && in_sphere(center) && cloud.opacity_logits[i] >= least_logit_;
  }

 private:
  bool in_box(const glm::dvec3& p) const {
    const auto& box = options_.box;
    for (int c = 0; c < 3 && !box.empty(); ++c) {
      const auto axis = static_cast<std::size_t>(c);
      if (!(p[c] >= box[axis] && p[c] <= box[axis + 3])) return false;
    }
    return true;
  }
  bool in_sphere(const glm::dvec3& p) const {
    const auto& s = options_.sphere;
    return s.empty() || glm::distance(p, glm::dvec3(s[0], s[1], s[2])) <= s[3];
  }

  const CropOptions& options_;
  double least_logit_;  ///< −∞ where there is no limit
};

constexpr const char* kCropGroup = "Leave out, before the scene is turned, resized or moved";

}  // namespace

void add_crop_options(CLI::App& command, CropOptions& options) {
  const auto numbers = [&](const char* name, std::vector<double>& to, int count, const char* type,
                           const char* help) {
    command.add_option(name, to, help)
        ->delimiter(',')
        ->expected(count)
        ->check(in_range(-kFarthest, kFarthest).description(""))
        ->type_name(type)
        ->group(kCropGroup);
  };
  numbers("--crop", options.box, 6, "X0,Y0,Z0,X1,Y1,Z1", "keep the splats in this box");
  numbers("--crop-sphere", options.sphere, 4, "X,Y,Z,R", "keep the splats in this sphere");
  command.add_option("--min-opacity", options.min_opacity, "keep splats of at least this opacity")
      ->check(in_range(0, 0.999))
      ->group(kCropGroup);
}

void check_crop(const CropOptions& options) {
  const auto& box = options.box;
  for (std::size_t c = 0; c < 3 && !box.empty(); ++c)
    if (!(box[c] < box[c + 3]))
      throw CLI::ValidationError(
          "--crop", fmt::format("expected the least {} before the greatest, not {:g},{:g}",
                                "xyz"[c], box[c], box[c + 3]));
  if (!options.sphere.empty() && !(options.sphere[3] > 0))
    throw CLI::ValidationError(
        "--crop-sphere", fmt::format("expected a radius above 0, not {:g}", options.sphere[3]));
}

std::string limits_of(const CropOptions& options) {
  std::vector<std::string> names;
  if (!options.box.empty()) names.emplace_back("--crop");
  if (!options.sphere.empty()) names.emplace_back("--crop-sphere");
  if (options.min_opacity > 0) names.emplace_back("--min-opacity");
  return fmt::format("{}", fmt::join(names, " and "));
}

std::size_t crop_scene(const CropOptions& options, SplatCloud& cloud) {
  if (!options.crops()) return 0;
  const Keep keep(options);
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (keep(cloud, i)) kept.push_back(static_cast<std::uint32_t>(i));
  const std::size_t left_out = cloud.size() - kept.size();
  cloud = in_order(cloud, kept);
  return left_out;
}

}  // namespace fluxgs::cli
