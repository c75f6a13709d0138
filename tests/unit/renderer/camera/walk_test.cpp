// Walking at eye height, and not out of the scene.
#include "camera/walk.h"

#include "camera/navigation.h"
#include "camera/orbit.h"
#include "camera/pan_zoom.h"
#include "support.h"

namespace fluxgs::camera::test {
namespace {

SceneUnits scene() {
  SceneUnits units;
  units.center = {1, 2, 3};
  units.radius = 5;
  units.speed = 2;
  return units;
}

double height_of(const ViewState& view) { return glm::dot(eye(view), kUp); }

double away(const ViewState& view) {
  const glm::dvec3 arm = eye(view) - scene().center;
  return glm::length(arm - kUp * glm::dot(arm, kUp));
}

/// From above and outside, looking down at the scene.
Navigation from_above() {
  return navigation_from(view_between({1, -20, -15}, {1, 2, 3}, kUp, 0.9), kUp, scene());
}

/// Where somebody took photos.
Navigation from_within() {
  return navigation_from(view_between({2, 1.5, 1}, {1, 2.5, 5}, kUp, 0.9), kUp, scene());
}

void arrive(Navigation& n) {
  for (int i = 0; i < 100 && n.transition; ++i) advance(n, 1.0 / 60, kSize);
  EXPECT_FALSE(n.transition);
}

TEST(Walk, IsAtTheHeightOfWhoTookThePhotosOrInTheMiddle) {
  EXPECT_NEAR(eye_height(from_within().home, scene(), kUp), -1.5, 1e-12);
  EXPECT_NEAR(eye_height(from_above().home, scene(), kUp), -2, 1e-12);
}

TEST(Walk, BeginsInTheSceneUprightAndLevel) {
  Navigation n = from_above();
  n.view = twist(n.view, 0.4, {320, 240}, kSize);
  start_walking(n);
  expect_same_view(n.view, n.transition->from);
  arrive(n);
  EXPECT_NEAR(height_of(n.view), -2, 1e-9);
  EXPECT_LE(away(n.view), scene().radius + 1e-9);
  EXPECT_NEAR(roll(n.view, kUp), 0, 1e-9);
  EXPECT_NEAR(elevation(n.view, kUp), 0, 1e-9);
}

TEST(Walk, GoesWhereTheStickPointsAndNotUp) {
  Navigation n = from_within();
  start_walking(n);
  arrive(n);
  const ViewState begin = n.view;
  const glm::dvec3 ahead = level_direction(begin, kUp);
  n.flying = {.forward = 1};
  for (int i = 0; i < 60; ++i) EXPECT_TRUE(advance(n, 1.0 / 60, kSize));
  const glm::dvec3 way = eye(n.view) - eye(begin);
  EXPECT_LT(glm::distance(way, 0.8 * ahead), 1e-9) << "0.4 of the speed of flying";
  n.flying = {.right = 1, .forward = 1};
  const ViewState before = n.view;
  for (int i = 0; i < 60; ++i) advance(n, 1.0 / 60, kSize);
  EXPECT_NEAR(glm::distance(eye(n.view), eye(before)), 0.8, 1e-9) << "slanted is not faster";
  EXPECT_GT(glm::dot(eye(n.view) - eye(before), right(begin)), 0.5);
  EXPECT_NEAR(height_of(n.view), height_of(begin), 1e-12);
  n.flying = {};
  EXPECT_FALSE(advance(n, 1.0 / 60, kSize));
}

TEST(Walk, CannotLeaveTheSceneAndSlidesAlongItsBorder) {
  Navigation n = from_within();
  start_walking(n);
  arrive(n);
  n.flying = {.right = 0.3, .forward = 1};
  for (int i = 0; i < 60 * 60; ++i) {
    advance(n, 1.0 / 60, kSize);
    ASSERT_LE(away(n.view), scene().radius + 1e-9);
  }
  const ViewState at_border = n.view;
  EXPECT_NEAR(away(at_border), scene().radius, 1e-6);
  n.flying = {.forward = -1};
  for (int i = 0; i < 60; ++i) advance(n, 1.0 / 60, kSize);
  EXPECT_LT(away(n.view), away(at_border)) << "back in";
}

TEST(Walk, WhateverMovesTheViewItStaysOnFoot) {
  Navigation n = from_within();
  start_walking(n);
  arrive(n);
  drag(n, DragAction::pan, {200, 300}, kSize);
  keep_on_foot(n);
  EXPECT_NEAR(height_of(n.view), -1.5, 1e-9);
  n.view = zoom(n.view, 0.01, {320, 240}, kSize);
  keep_on_foot(n);
  EXPECT_NEAR(height_of(n.view), -1.5, 1e-9);
  EXPECT_LE(away(n.view), scene().radius + 1e-9);
  go_to(n, from_above().view);
  arrive(n);
  EXPECT_NEAR(height_of(n.view), -1.5, 1e-9);
}

TEST(Walk, AFingerDoesNotEndTheWayToItsBeginning) {
  Navigation n = from_above();
  start_walking(n);
  advance(n, 0.1, kSize);
  touch(n);
  n.flying = {.forward = 1};
  ViewState before = n.view;
  for (int i = 0; i < 40; ++i) {
    advance(n, 1.0 / 60, kSize);
    EXPECT_LT(glm::distance(eye(n.view), eye(before)), 4) << "no jump";
    before = n.view;
  }
  EXPECT_NEAR(height_of(n.view), -2, 1e-9);
}

TEST(Walk, EndsWithWhatLeadsAway) {
  for (void (*other)(Navigation&) : {&reset, &flip_up, &drift, &stop_walking}) {
    Navigation n = from_above();
    start_walking(n);
    n.flying = {.forward = 1};
    other(n);
    EXPECT_FALSE(n.walking);
    EXPECT_EQ(n.flying.forward, 0);
  }
}

}  // namespace
}  // namespace fluxgs::camera::test
