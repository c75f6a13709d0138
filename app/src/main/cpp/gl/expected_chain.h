// Putting steps that may fail one after the other.
#pragma once

#include <utility>

#include "fluxgs/error.h"

namespace fluxgs::gl {

/// Runs the steps, each a callable that returns Expected<void>, until one fails.
template <class... Steps>
Expected<void> chain(Steps&&... steps) {
  Expected<void> result;
  static_cast<void>(((result = steps()).has_value() && ...));
  return result;
}

/// Moves the value of `from` into `into`, or passes the error on.
template <class From, class Into>
Expected<void> assign_or_error(Expected<From> from, Into& into) {
  if (!from) return std::unexpected(std::move(from.error()));
  into = std::move(*from);
  return {};
}

}  // namespace fluxgs::gl
