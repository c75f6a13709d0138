// The check of a device's driver, before the app draws with it.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "viewer/screen.h"

namespace fluxgs::viewer {

/// Draws a scene file in a context that `screen` makes, compares with its golden picture
/// (bench::check_driver()), and returns bench::to_json() of that. `golden`: a lossless WebP image
/// of the view that the scene is shown with first. `known`: "renderer, version" of a driver that
/// was checked; the result is empty if this is it. Fails, with the name of the file in the message,
/// on a scene or a picture that cannot be read, and where there is no OpenGL ES 3.1.
Expected<std::string> check_driver_of(Screen& screen, std::span<const std::byte> scene,
                                      std::span<const std::byte> golden, const std::string& known);

}  // namespace fluxgs::viewer
