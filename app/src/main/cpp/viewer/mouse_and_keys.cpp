#include "viewer/mouse_and_keys.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>

#include <glm/geometric.hpp>

namespace fluxgs::viewer {
namespace {

using camera::DragAction;
using camera::Navigation;

constexpr double kNotch = 1.15;  // of the wheel
constexpr double kSpeedStep = 1.5, kSlowest = 1e-3, kFastest = 1e3;
constexpr double kDoubleClick = 0.4, kDoubleClickReach = 6;  // seconds, px

bool is_down(const MouseAndKeys& input, char letter) {
  return input.letters[static_cast<std::size_t>(letter - 'A')];
}

bool is_flying(const MouseAndKeys& input) {
  constexpr std::string_view kFlying = "WASDQE";
  return std::ranges::any_of(kFlying, [&](char letter) { return is_down(input, letter); });
}

DragAction action_of(PointerButton button, const MouseAndKeys& input, const Navigation& n) {
  if (button != PointerButton::left) return DragAction::pan;
  return n.walking || is_flying(input) ? DragAction::look : DragAction::orbit;
}

/// True if this press of the left button is the second of two.
bool completes_double_click(const WindowEvent& event, double time, MouseAndKeys& input) {
  const bool second = time - input.last_press < kDoubleClick &&
                      glm::distance(event.position, input.last_press_at) < kDoubleClickReach;
  input.last_press = second ? -1e9 : time;  // the third is the first again
  input.last_press_at = event.position;
  return second;
}

std::optional<glm::dvec2> press(const WindowEvent& event, double time, MouseAndKeys& input,
                                Navigation& n) {
  if (input.dragging) return std::nullopt;
  camera::touch(n);
  input.dragging = event.button;
  input.trail = {};
  camera::add(input.trail, time, event.position);
  if (event.button != PointerButton::left || !completes_double_click(event, time, input))
    return std::nullopt;
  return event.position;
}

void lift(const WindowEvent& event, double time, MouseAndKeys& input, Navigation& n) {
  if (input.dragging != event.button) return;
  input.dragging.reset();
  if (!n.transition)
    camera::release(n, action_of(event.button, input, n), camera::velocity(input.trail, time));
}

void move(const WindowEvent& event, double time, const glm::dvec2& size, MouseAndKeys& input,
          Navigation& n) {
  const glm::dvec2 way = event.position - input.pointer;
  input.pointer = event.position;
  if (!input.dragging || way == glm::dvec2(0.0)) return;
  camera::touch(n);
  camera::add(input.trail, time, event.position);
  camera::drag(n, action_of(*input.dragging, input, n), way, size);
}

void hold(char key, bool down, MouseAndKeys& input, Navigation& n) {
  if (!std::isupper(static_cast<unsigned char>(key))) return;
  input.letters[static_cast<std::size_t>(key - 'A')] = down;
  const auto way = [&](char plus, char minus) {
    return (is_down(input, plus) ? 1.0 : 0.0) - (is_down(input, minus) ? 1.0 : 0.0);
  };
  n.flying = {.right = way('D', 'A'), .up = way('E', 'Q'), .forward = way('W', 'S')};
  if (down && is_flying(input)) camera::touch(n);
}

void type(char letter, Navigation& n) {
  const auto faster = [&](double factor) {
    n.speed_factor = std::clamp(n.speed_factor * factor, kSlowest, kFastest);
  };
  switch (letter) {
    case 'f':
    case 'F':
      camera::flip_up(n);
      break;
    case 'o':
    case 'O':
      if (!n.drift) return camera::drift(n);
      n.drift.reset();
      break;
    case 'r':
    case 'R':
      camera::reset(n);
      break;
    case '+':
      faster(kSpeedStep);
      break;
    case '-':
      faster(1 / kSpeedStep);
      break;
    default:
      break;
  }
}

}  // namespace

std::optional<glm::dvec2> apply(const WindowEvent& event, double seconds, const glm::dvec2& size,
                                MouseAndKeys& input, Navigation& n) {
  switch (event.kind) {
    case WindowEvent::Kind::pointer_moved:
      move(event, seconds, size, input, n);
      break;
    case WindowEvent::Kind::button:
      input.pointer = event.position;
      if (event.down) return press(event, seconds, input, n);
      lift(event, seconds, input, n);
      break;
    case WindowEvent::Kind::scrolled:
      camera::touch(n);
      n.view = camera::zoom(n.view, std::pow(kNotch, event.amount), event.position, size,
                            n.units.distances);
      break;
    case WindowEvent::Kind::key:
      hold(event.key, event.down, input, n);
      break;
    case WindowEvent::Kind::text:
      type(event.key, n);
      break;
    case WindowEvent::Kind::focus_lost:
      input.letters = {};
      input.dragging.reset();
      n.flying = {};
      break;
    case WindowEvent::Kind::uncovered:
      break;
  }
  return std::nullopt;
}

}  // namespace fluxgs::viewer
