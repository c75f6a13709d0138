#include "tools/capture/texture.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "tools/capture/noise.h"

namespace fluxgs::capture {
namespace {

/// True if the floor of x is odd.
bool is_odd(float x) { return (floor_to_int(x) & 1) != 0; }

glm::vec3 checker_marble(const glm::vec3& color, const glm::vec3& p, std::uint32_t seed) {
  const float veins = std::abs(std::sin(5 * p.x + 3 * p.y + 7 * fractal_noise(2.0F * p, 4, seed)));
  const glm::vec3 dark(0.035F, 0.05F, 0.075F);
  const bool light = is_odd(p.x / 0.6F) != is_odd(p.y / 0.6F);
  return light ? color * (0.55F + 0.45F * std::pow(veins, 0.4F))
               : dark + 0.07F * std::pow(1 - veins, 6.0F);
}

glm::vec3 plaster_stripes(const glm::vec3& color, const glm::vec3& p, std::uint32_t seed) {
  const float grain = fractal_noise(6.0F * p, 4, seed);
  const float blotches = fractal_noise(1.3F * p, 2, seed + 1);
  const glm::vec3 second(0.62F, 0.50F, 0.36F);
  const glm::vec3 stripe = is_odd((p.x + 0.12F * p.z) / 0.42F) ? color : second;
  return stripe * (0.45F + 0.5F * grain + 0.3F * blotches);
}

glm::vec3 bands(const glm::vec3& color, const glm::vec3& p) {
  const glm::vec3 axis = glm::normalize(glm::vec3(0.3F, -0.5F, 0.8F));
  return is_odd(glm::dot(p, axis) / 0.11F) ? color : glm::vec3(0.82F, 0.80F, 0.74F);
}

glm::vec3 speckles(const glm::vec3& color, const glm::vec3& p, std::uint32_t seed) {
  const float spots = glm::smoothstep(0.55F, 0.62F, fractal_noise(9.0F * p, 3, seed));
  return glm::mix(color, glm::vec3(0.85F, 0.78F, 0.45F), spots);
}

/// Noise with its contrast raised around the mean; 0…1.
float harder(float noise, float contrast) {
  return glm::clamp(0.5F + contrast * (noise - 0.5F), 0.0F, 1.0F);
}

glm::vec3 grass(const glm::vec3& color, const glm::vec3& p, float footprint, std::uint32_t seed) {
  const float blades = harder(detail_noise(12.0F * p, 4, 1.2F, 12 * footprint, seed), 4.0F);
  const float patches = harder(detail_noise(0.08F * p, 6, 0.9F, 0.08F * footprint, seed + 7), 2.5F);
  const glm::vec3 straw(0.36F, 0.29F, 0.13F);
  return glm::mix(color, straw, 0.5F * patches) * (0.2F + 1.2F * blades);
}

glm::vec3 foliage(const glm::vec3& color, const glm::vec3& p, float footprint, std::uint32_t seed) {
  const float twigs = harder(detail_noise(5.0F * p, 2, 0.7F, 5 * footprint, seed), 2.0F);
  const float leaves = harder(detail_noise(16.0F * p, 3, 1.1F, 16 * footprint, seed + 5), 4.5F);
  const glm::vec3 bright = color * glm::vec3(1.9F, 1.7F, 1.0F);
  return glm::mix(color, bright, leaves) * (0.1F + 1.1F * twigs * leaves + 0.35F * leaves);
}

glm::vec3 rock(const glm::vec3& color, const glm::vec3& p, float footprint, std::uint32_t seed) {
  const float grain = harder(detail_noise(10.0F * p, 4, 1.2F, 10 * footprint, seed), 4.0F);
  const float lichen = detail_noise(4.0F * p, 4, 0.6F, 4 * footprint, seed + 9);
  const glm::vec3 lichens(0.42F, 0.40F, 0.20F);
  return glm::mix(color, lichens, glm::smoothstep(0.56F, 0.64F, lichen)) * (0.35F + 1.1F * grain);
}

glm::vec3 whitewash(const glm::vec3& color, const glm::vec3& p, float footprint,
                    std::uint32_t seed) {
  return color * (0.97F + 0.06F * detail_noise(1.5F * p, 3, 0.5F, 1.5F * footprint, seed));
}

/// 0 on the border of a cell, 1 inside, over a rim that is never narrower than a pixel; `place` and
/// the widths in the same unit.
float inside_cell(float place, float size, float border, float footprint) {
  const float edge = std::min(place, size - place);
  const float rim = 0.5F * std::max(footprint, 0.3F * border);
  return glm::smoothstep(0.5F * border - rim, 0.5F * border + rim, edge);
}

glm::vec3 planks(const glm::vec3& color, const glm::vec3& p, float footprint, std::uint32_t seed) {
  constexpr float kWidth = 0.14F, kLength = 1.3F, kGap = 0.006F;
  const int row = floor_to_int(p.y / kWidth);
  const float along = p.x + kLength * grid_noise(row, 0, 0, seed);
  const int plank = floor_to_int(along / kLength);
  const float tone = grid_noise(row, plank, 1, seed);
  // Fibres: noise that is drawn out along the plank, and another one on each.
  const glm::vec3 fibre(2.0F * along, 30.0F * p.y, 9.0F * tone);
  const float grain = harder(detail_noise(fibre, 3, 0.8F, 30 * footprint, seed + 2), 1.6F);
  const float gaps =
      inside_cell(p.y - kWidth * static_cast<float>(row), kWidth, kGap, footprint) *
      inside_cell(along - kLength * static_cast<float>(plank), kLength, kGap, footprint);
  return color * ((0.6F + 0.5F * tone) * (0.65F + 0.5F * grain) * (0.25F + 0.75F * gaps));
}

glm::vec3 picture(const glm::vec3& color, const glm::vec3& p, float footprint, std::uint32_t seed) {
  const auto shapes = [&](float frequency, std::uint32_t which) {
    const float noise =
        detail_noise(frequency * p, 4, 0.6F, frequency * footprint, seed + 11 * which);
    return glm::smoothstep(0.47F, 0.53F, noise);
  };
  const glm::vec3 paint(shapes(4, 1), shapes(5, 2), shapes(6, 3));
  const float strokes = harder(detail_noise(30.0F * p, 2, 0.8F, 30 * footprint, seed), 1.5F);
  return glm::mix(color, paint, 0.75F) * (0.35F + 0.6F * strokes);
}

glm::vec3 bricks(const glm::vec3& color, const glm::vec3& p, float footprint, std::uint32_t seed) {
  constexpr float kHeight = 0.09F, kLength = 0.27F, kMortar = 0.016F;
  const int course = floor_to_int(p.z / kHeight);
  const float along = p.x + ((course & 1) != 0 ? 0.5F * kLength : 0.0F);
  const int brick = floor_to_int(along / kLength);
  const float tone = grid_noise(course, brick, 0, seed);
  const float grain = harder(detail_noise(20.0F * p, 4, 1.2F, 20 * footprint, seed + 3), 5.0F);
  const float face =
      inside_cell(p.z - kHeight * static_cast<float>(course), kHeight, kMortar, footprint) *
      inside_cell(along - kLength * static_cast<float>(brick), kLength, kMortar, footprint);
  const glm::vec3 mortar(0.50F, 0.47F, 0.42F), plaster(0.66F, 0.60F, 0.48F);
  const glm::vec3 burnt = glm::mix(color, 0.45F * color, tone);
  const glm::vec3 wall = glm::mix(mortar, burnt, face);
  const float flakes = detail_noise(0.9F * p, 6, 0.55F, 0.9F * footprint, seed + 8);
  return glm::mix(wall, plaster, glm::smoothstep(0.535F, 0.55F, flakes)) * (0.35F + 1.1F * grain);
}

}  // namespace

glm::vec3 texture_color(Texture texture, const glm::vec3& color, const glm::vec3& p,
                        float footprint, std::uint32_t seed) {
  switch (texture) {
    case Texture::kCheckerMarble:
      return checker_marble(color, p, seed);
    case Texture::kPlasterStripes:
      return plaster_stripes(color, p, seed);
    case Texture::kBands:
      return bands(color, p);
    case Texture::kSpeckles:
      return speckles(color, p, seed);
    case Texture::kGrass:
      return grass(color, p, footprint, seed);
    case Texture::kFoliage:
      return foliage(color, p, footprint, seed);
    case Texture::kRock:
      return rock(color, p, footprint, seed);
    case Texture::kWhitewash:
      return whitewash(color, p, footprint, seed);
    case Texture::kPlanks:
      return planks(color, p, footprint, seed);
    case Texture::kPicture:
      return picture(color, p, footprint, seed);
    case Texture::kBricks:
      return bricks(color, p, footprint, seed);
    case Texture::kPlain:
      break;
  }
  return color;
}

}  // namespace fluxgs::capture
