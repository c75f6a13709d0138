#include "tools/capture/scenes.h"

#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "trainer/core/random.h"

namespace fluxgs::capture {
namespace {

using glm::vec3;

constexpr float kTurn = 2 * std::numbers::pi_v<float>;

float between(Random& random, float low, float high) {
  return low + (high - low) * static_cast<float>(uniform(random));
}

/// A place on the ground.
vec3 polar(float azimuth, float radius) {
  return {radius * std::cos(azimuth), radius * std::sin(azimuth), 0};
}

void light_studio(Scene& scene) {
  scene.sky = Sky::kStudio;
  scene.light_below = {0.12F, 0.11F, 0.10F};
  scene.light_above = {0.32F, 0.36F, 0.42F};
  scene.lamps = {
      {glm::normalize(vec3(-0.55F, -0.65F, 0.95F)), {1.75F, 1.58F, 1.32F}, 0.09F},
      {glm::normalize(vec3(0.95F, -0.55F, 0.75F)), {0.42F, 0.50F, 0.66F}, 0.16F},
      {glm::normalize(vec3(0.15F, -0.9F, 0.35F)), {0.22F, 0.19F, 0.17F}, 0.12F},
  };
}

Scene spheres() {
  constexpr float kWallY = 2.1F, kHalfWidth = 2.7F, kHeight = 2.5F;
  Scene scene;
  light_studio(scene);
  scene.floor = {3.4F, kWallY, {Texture::kCheckerMarble, {0.78F, 0.75F, 0.69F}, 0.18F, false}};
  const Material wall{Texture::kPlasterStripes, {0.16F, 0.34F, 0.37F}, 0.8F, false};
  scene.boxes = {{{-kHalfWidth, kWallY, 0}, {kHalfWidth, kWallY, kHeight}, wall, false}};
  scene.planes = {{{0, 0, 1}, 0}, {{0, -1, 0}, -kWallY}};
  const Material chrome{Texture::kPlain, {0.93F, 0.94F, 0.96F}, 0.04F, true};
  const Material lacquer{Texture::kPlain, {0.62F, 0.025F, 0.02F}, 0.1F, false};
  const Material gold{Texture::kPlain, {1.0F, 0.70F, 0.27F}, 0.3F, true};
  const Material banded{Texture::kBands, {0.03F, 0.09F, 0.42F}, 0.12F, false};
  const Material jade{Texture::kSpeckles, {0.03F, 0.26F, 0.12F}, 0.16F, false};
  const Material pearl{Texture::kPlain, {0.80F, 0.74F, 0.70F}, 0.22F, false};
  scene.spheres = {
      {{-0.95F, 0.75F, 0.80F}, 0.80F, chrome},  {{0.85F, 0.45F, 0.60F}, 0.60F, lacquer},
      {{0.05F, -0.55F, 0.38F}, 0.38F, gold},    {{-1.05F, -0.75F, 0.32F}, 0.32F, banded},
      {{1.20F, -0.75F, 0.28F}, 0.28F, jade},    {{0.10F, 1.30F, 0.35F}, 0.35F, pearl},
      {{0.45F, -1.35F, 0.17F}, 0.17F, lacquer}, {{-0.42F, -1.30F, 0.14F}, 0.14F, chrome}};
  return scene;
}

/// Spheres close together on the ground, the larger ones in the middle.
void add_cluster(Scene& scene, const vec3& place, float radius, int count, const Material& material,
                 Random& random) {
  for (int i = 0; i < count; ++i) {
    const float off = 0.75F * radius * std::sqrt(static_cast<float>(i) / static_cast<float>(count));
    const float size = between(random, 0.45F, 0.65F) * (radius - 0.6F * off);
    const vec3 center = place + polar(between(random, 0, kTurn), off);
    const float height = between(random, 0.3F, 0.65F) * (radius - 0.8F * off);
    scene.spheres.push_back({center + vec3(0, 0, height), size, material});
  }
}

void add_near_things(Scene& scene, Random& random) {
  const vec3 greens[] = {{0.10F, 0.17F, 0.04F}, {0.06F, 0.13F, 0.05F}, {0.16F, 0.17F, 0.04F}};
  const vec3 greys[] = {{0.36F, 0.34F, 0.32F}, {0.42F, 0.35F, 0.27F}};
  constexpr int kThings = 9;
  for (int i = 0; i < kThings; ++i) {
    const vec3 place = polar(2.4F * static_cast<float>(i), std::sqrt(0.7F * static_cast<float>(i)));
    const Material leaves{Texture::kFoliage, greens[i % 3], 0.8F, false};
    const Material stone{Texture::kRock, greys[i % 2], 0.75F, false};
    if (i % 3 == 1)
      add_cluster(scene, place, between(random, 0.3F, 0.5F), 6, stone, random);
    else
      add_cluster(scene, place, between(random, 0.6F, 0.95F), 14, leaves, random);
  }
  const Material pillar{Texture::kRock, {0.50F, 0.47F, 0.42F}, 0.8F, false};
  scene.boxes = {{{0.9F, 0.6F, 0}, {1.3F, 1.0F, 1.5F}, pillar},
                 {{0.8F, 0.5F, 1.5F}, {1.4F, 1.1F, 1.62F}, pillar}};
}

/// Bushes beyond the cameras, rows of trees with gaps, and hills behind them.
void add_background(Scene& scene, Random& random) {
  constexpr int kBushes = 12, kTrees = 32, kHills = 11;
  for (int i = 0; i < kBushes; ++i) {
    const Material leaves{Texture::kFoliage, {0.10F, 0.15F, 0.04F}, 0.8F, false, 1.5F};
    const float azimuth = between(random, 0, kTurn), away = between(random, 13, 28);
    add_cluster(scene, polar(azimuth, away), between(random, 0.9F, 2.0F), 4, leaves, random);
  }
  for (int i = 0; i < kTrees; ++i) {
    const float shade = between(random, 0.6F, 1.2F);
    const Material leaves{Texture::kFoliage, shade * vec3(0.09F, 0.14F, 0.05F), 0.9F, false, 5.0F};
    const float row = std::floor(between(random, 0, 9)) * kTurn / 9;
    const float azimuth = row + between(random, -0.22F, 0.22F), away = between(random, 38, 85);
    add_cluster(scene, polar(azimuth, away), between(random, 3.5F, 8.0F), 4, leaves, random);
  }
  for (int i = 0; i < kHills; ++i) {
    const Material woods{Texture::kFoliage, {0.10F, 0.14F, 0.06F}, 0.9F, false, 30.0F};
    const float radius = between(random, 80, 150), height = between(random, 14, 42);
    const float azimuth = kTurn * (static_cast<float>(i) + between(random, 0, 0.8F)) / kHills;
    const vec3 place = polar(azimuth, between(random, 220, 380));
    scene.spheres.push_back({place + vec3(0, 0, height - radius), radius, woods});
  }
}

Scene outdoor(std::uint32_t seed) {
  Scene scene;
  Random random(seed);
  scene.sky = Sky::kClouds;
  scene.light_below = {0.10F, 0.12F, 0.06F};
  scene.light_above = {0.34F, 0.44F, 0.60F};
  scene.lamps = {{glm::normalize(vec3(-0.5F, -0.6F, 0.8F)), {2.3F, 2.1F, 1.75F}, 0.03F}};
  scene.haze = 1 / 900.0F;
  scene.floor.radius = 600;
  scene.floor.material = {Texture::kGrass, {0.13F, 0.19F, 0.05F}, 0.9F, false};
  add_near_things(scene, random);
  add_background(scene, random);
  return scene;
}

/// A box whose sides are along the axes, from the middle of its base.
Box block(const vec3& base, const vec3& size, const Material& material) {
  const vec3 half(0.5F * size.x, 0.5F * size.y, 0);
  return {base - half, base + half + vec3(0, 0, size.z), material};
}

constexpr vec3 kRoomHalf(3.0F, 2.5F, 0);
constexpr float kRoomHeight = 2.7F;

void add_walls(Scene& scene) {
  const float x = kRoomHalf.x, y = kRoomHalf.y, z = kRoomHeight;
  const Material white{Texture::kWhitewash, {0.74F, 0.73F, 0.70F}, 0.9F, false};
  scene.boxes.insert(scene.boxes.end(), {{{-x, -y, 0}, {-x, y, z}, white, false},
                                         {{x, -y, 0}, {x, y, z}, white, false},
                                         {{-x, -y, 0}, {x, -y, z}, white, false},
                                         {{-x, y, 0}, {x, y, z}, white, false},
                                         {{-x, -y, z}, {x, y, z}, white, false}});
  scene.planes = {{{1, 0, 0}, -x},  {{-1, 0, 0}, -x}, {{0, 1, 0}, -y},
                  {{0, -1, 0}, -y}, {{0, 0, 1}, 0},   {{0, 0, -1}, -z}};
}

/// A canvas in a frame on the wall that is at ±x or at ±y of the room.
void add_picture(Scene& scene, int axis, float side, float along, float width, float height) {
  constexpr float kCenter = 1.55F, kDepth = 0.03F, kRim = 0.04F;
  vec3 center(along, along, kCenter);
  vec3 half(0.5F * width, 0.5F * width, 0.5F * height);
  center[axis] = side * (kRoomHalf[axis] - 0.5F * kDepth);
  half[axis] = 0.5F * kDepth;
  const Material frame{Texture::kPlain, {0.05F, 0.035F, 0.025F}, 0.5F, false};
  const Material canvas{Texture::kPicture, {0.55F, 0.42F, 0.25F}, 0.8F, false};
  scene.boxes.push_back({center - half, center + half, frame, false});
  half -= vec3(kRim);
  center[axis] -= side * (0.5F * kDepth + 0.003F);
  half[axis] = 0;
  scene.boxes.push_back({center - half, center + half, canvas, false});
}

void add_furniture(Scene& scene) {
  const Material oak{Texture::kPlanks, {0.40F, 0.25F, 0.12F}, 0.5F, false};
  const Material dark{Texture::kPlain, {0.06F, 0.045F, 0.04F}, 0.35F, false};
  const Material cloth{Texture::kSpeckles, {0.07F, 0.12F, 0.22F}, 0.9F, false, 0.3F};
  const Material cushion{Texture::kBands, {0.55F, 0.12F, 0.06F}, 0.9F, false};
  const Material glaze{Texture::kPlain, {0.10F, 0.33F, 0.36F}, 0.12F, false};
  const Material leaves{Texture::kFoliage, {0.08F, 0.15F, 0.04F}, 0.7F, false};
  const Material paper{Texture::kPlain, {0.80F, 0.72F, 0.55F}, 0.8F, false};
  // A sofa, a low table, a cupboard, a shelf with books, a plant.
  scene.boxes.insert(scene.boxes.end(), {block({-0.6F, 2.05F, 0}, {2.0F, 0.85F, 0.42F}, cloth),
                                         block({-0.6F, 2.38F, 0.42F}, {2.0F, 0.2F, 0.42F}, cloth),
                                         block({-1.5F, 2.0F, 0.42F}, {0.2F, 0.7F, 0.18F}, cloth),
                                         block({0.3F, 2.0F, 0.42F}, {0.2F, 0.7F, 0.18F}, cloth),
                                         block({-0.5F, 0.5F, 0.28F}, {1.0F, 0.6F, 0.08F}, oak),
                                         block({-0.5F, 0.5F, 0}, {0.5F, 0.3F, 0.28F}, dark),
                                         block({2.7F, -0.6F, 0}, {0.55F, 1.5F, 0.75F}, oak),
                                         block({-2.75F, -1.4F, 0}, {0.45F, 1.2F, 1.9F}, dark),
                                         block({1.0F, -2.2F, 0}, {1.3F, 0.5F, 0.7F}, oak),
                                         block({2.55F, 2.1F, 0}, {0.4F, 0.4F, 0.35F}, glaze)});
  for (int shelf = 0; shelf < 4; ++shelf)
    for (int book = 0; book < 9; ++book) {
      const auto s = static_cast<float>(shelf), b = static_cast<float>(book);
      const vec3 color(0.1F + 0.4F * std::abs(std::sin(3 * b + s)),
                       0.1F + 0.25F * std::abs(std::sin(5 * b + 2 * s)), 0.12F + 0.02F * b);
      scene.boxes.push_back(block({-2.53F, -1.9F + 0.12F * b, 0.12F + 0.45F * s},
                                  {0.04F, 0.1F, 0.24F + 0.02F * std::fmod(7 * b, 5.0F)},
                                  {Texture::kPlain, color, 0.7F, false}));
    }
  scene.spheres = {{{-0.6F, 0.5F, 0.48F}, 0.12F, glaze},   {{-0.25F, 0.6F, 0.43F}, 0.07F, cushion},
                   {{-1.2F, 2.1F, 0.60F}, 0.20F, cushion}, {{2.65F, -0.9F, 0.93F}, 0.18F, glaze},
                   {{2.65F, -0.3F, 1.0F}, 0.25F, paper},   {{0.7F, -2.2F, 0.85F}, 0.15F, cushion},
                   {{2.55F, 2.1F, 0.75F}, 0.32F, leaves},  {{2.4F, 1.95F, 1.05F}, 0.22F, leaves},
                   {{2.65F, 2.15F, 1.15F}, 0.25F, leaves}, {{1.4F, -1.2F, 0.22F}, 0.22F, cloth}};
}

Scene room() {
  Scene scene;
  light_studio(scene);
  // White walls throw the light back from all sides.
  scene.light_below = {0.62F, 0.58F, 0.52F};
  scene.light_above = {0.66F, 0.66F, 0.66F};
  scene.floor.radius = 4.5F;
  scene.floor.material = {Texture::kPlanks, {0.42F, 0.24F, 0.11F}, 0.22F, false};
  add_walls(scene);
  add_picture(scene, 1, 1, -0.6F, 1.1F, 0.75F);
  add_picture(scene, 1, 1, 1.4F, 0.5F, 0.65F);
  add_picture(scene, 1, -1, -0.9F, 0.8F, 0.6F);
  add_picture(scene, 1, -1, 1.1F, 0.45F, 0.45F);
  add_picture(scene, 0, 1, 0.9F, 0.9F, 0.65F);
  add_picture(scene, 0, -1, 1.0F, 0.6F, 0.8F);
  add_furniture(scene);
  return scene;
}

Scene wall(std::uint32_t seed) {
  constexpr int kColumns = 4, kRows = 3;
  Scene scene;
  Random random(seed);
  light_studio(scene);
  // Light from the side, which shows how far something sticks out.
  scene.lamps = {{glm::normalize(vec3(-0.8F, -0.75F, 0.7F)), {1.9F, 1.75F, 1.5F}, 0.04F}};
  const Material bricks{Texture::kBricks, {0.42F, 0.15F, 0.08F}, 0.9F, false};
  scene.boxes = {{{-6, 0, -4}, {6, 0, 8}, bricks, false}};
  const Material stones[] = {{Texture::kRock, {0.40F, 0.38F, 0.35F}, 0.8F, false, 0.4F},
                             {Texture::kRock, {0.48F, 0.36F, 0.24F}, 0.8F, false, 0.3F},
                             {Texture::kFoliage, {0.10F, 0.15F, 0.04F}, 0.8F, false},
                             {Texture::kBands, {0.03F, 0.09F, 0.42F}, 0.2F, false}};
  for (int i = 0; i < kColumns * kRows; ++i) {
    const float column = static_cast<float>(i % kColumns) + between(random, 0.1F, 0.9F);
    const float row = static_cast<float>(i / kColumns) + between(random, 0.1F, 0.9F);
    const float radius = between(random, 0.12F, 0.34F);
    const vec3 center(-2.4F + 1.2F * column, between(random, -0.3F, 0.3F) * radius,
                      0.4F + 1.0F * row);
    scene.spheres.push_back({center, radius, stones[i % 4]});
  }
  return scene;
}

Scene shapes_of(SceneKind kind, std::uint32_t seed) {
  switch (kind) {
    case SceneKind::kOutdoor:
      return outdoor(seed);
    case SceneKind::kRoom:
      return room();
    case SceneKind::kWall:
      return wall(seed);
    case SceneKind::kSpheres:
      break;
  }
  return spheres();
}

}  // namespace

Scene make_scene(std::uint32_t seed, SceneKind kind) {
  Scene scene = shapes_of(kind, seed);
  scene.seed = seed;
  return scene;
}

}  // namespace fluxgs::capture
