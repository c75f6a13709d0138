#include "tools/fluxgs/view_input.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>

#include <glm/geometric.hpp>

namespace fluxgs::cli {
namespace {

using camera::DragAction;
using camera::Navigation;
using host::PointerButton;
using host::WindowEvent;

constexpr double kNotch = 1.15;  // of the wheel
constexpr double kSpeedStep = 1.5, kSlowest = 1e-3, kFastest = 1e3;
constexpr double kDoubleClick = 0.4, kDoubleClickReach = 6;  // seconds, px

bool is_down(const ViewInput& input, char letter) {
  return input.letters[static_cast<std::size_t>(letter - 'A')];
}

bool is_flying(const ViewInput& input) {
  constexpr std::string_view kFlying = "WASDQE";
  return std::ranges::any_of(kFlying, [&](char letter) { return is_down(input, letter); });
}

DragAction action_of(PointerButton button, const ViewInput& input) {
  if (button != PointerButton::left) return DragAction::pan;
  return is_flying(input) ? DragAction::look : DragAction::orbit;
}

/// Whether this press of the left button is the second of two.
bool completes_double_click(const WindowEvent& event, double time, ViewInput& input) {
  const bool second = time - input.last_press < kDoubleClick &&
                      glm::distance(event.position, input.last_press_at) < kDoubleClickReach;
  input.last_press = second ? -1e9 : time;  // the third is the first again
  input.last_press_at = event.position;
  return second;
}

void press(const WindowEvent& event, double time, ViewInput& input, Navigation& n,
           ViewRequest& request) {
  if (input.dragging) return;
  camera::touch(n);
  input.dragging = event.button;
  input.trail = {};
  camera::add(input.trail, time, event.position);
  if (event.button == PointerButton::left && completes_double_click(event, time, input))
    request.focus = event.position;
}

void lift(const WindowEvent& event, double time, ViewInput& input, Navigation& n) {
  if (input.dragging != event.button) return;
  input.dragging.reset();
  if (!n.transition)
    camera::release(n, action_of(event.button, input), camera::velocity(input.trail, time));
}

void move(const WindowEvent& event, double time, const glm::dvec2& size, ViewInput& input,
          Navigation& n) {
  const glm::dvec2 way = event.position - input.pointer;
  input.pointer = event.position;
  if (!input.dragging || way == glm::dvec2(0.0)) return;
  camera::touch(n);
  camera::add(input.trail, time, event.position);
  camera::drag(n, action_of(*input.dragging, input), way, size);
}

void hold(char key, bool down, ViewInput& input, Navigation& n) {
  if (!std::isupper(static_cast<unsigned char>(key))) return;
  input.letters[static_cast<std::size_t>(key - 'A')] = down;
  const auto way = [&](char plus, char minus) {
    return (is_down(input, plus) ? 1.0 : 0.0) - (is_down(input, minus) ? 1.0 : 0.0);
  };
  n.flying = {.right = way('D', 'A'), .up = way('E', 'Q'), .forward = way('W', 'S')};
  if (down && is_flying(input)) camera::touch(n);
}

void type(char letter, Navigation& n, ViewRequest& request) {
  const auto faster = [&](double factor) {
    n.speed_factor = std::clamp(n.speed_factor * factor, kSlowest, kFastest);
  };
  switch (letter) {
    case 'f':
    case 'F':
      camera::flip_up(n);
      break;
    case 'r':
    case 'R':
      camera::reset(n);
      break;
    case 'p':
    case 'P':
      request.print_camera = true;
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

ViewRequest apply(const WindowEvent& event, double time, const glm::dvec2& size, ViewInput& input,
                  Navigation& n) {
  ViewRequest request;
  switch (event.kind) {
    case WindowEvent::Kind::pointer_moved:
      move(event, time, size, input, n);
      break;
    case WindowEvent::Kind::button:
      input.pointer = event.position;
      if (event.down)
        press(event, time, input, n, request);
      else
        lift(event, time, input, n);
      break;
    case WindowEvent::Kind::scrolled:
      camera::touch(n);
      n.view = camera::zoom(n.view, std::pow(kNotch, event.amount), event.position, size,
                            n.units.distances);
      break;
    case WindowEvent::Kind::key:
      if (event.key == host::kEscape && event.down) request.quit = true;
      hold(event.key, event.down, input, n);
      break;
    case WindowEvent::Kind::text:
      type(event.key, n, request);
      break;
    case WindowEvent::Kind::focus_lost:
      input.letters = {};
      input.dragging.reset();
      n.flying = {};
      break;
    case WindowEvent::Kind::uncovered:
      break;
  }
  return request;
}

}  // namespace fluxgs::cli
