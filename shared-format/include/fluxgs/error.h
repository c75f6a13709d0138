// Failures as values: everything that reads bytes or touches the outside world returns Expected<T>.
#pragma once

#include <expected>
#include <string>
#include <utility>

namespace fluxgs {

/// One failure, explained in one line: which file, which part of it, what was wrong and what was
/// expected instead.
struct Error {
  std::string file;  ///< the path (or device) concerned; may be empty
  std::string
      field;  ///< the place inside it, e.g. "header", "frame 3: transform_matrix"; may be empty
  std::string what;  ///< what was wrong, and what was expected

  /// "FILE: FIELD: WHAT", leaving out empty parts.
  std::string message() const {
    std::string text = file;
    if (!field.empty()) text += (text.empty() ? "" : ": ") + field;
    return text + (text.empty() ? "" : ": ") + what;
  }
};

/// A value, or the reason why there is none.
template <class T>
using Expected = std::expected<T, Error>;

/// Shorthand for `return fail(file, field, what);` from a function returning Expected<T>.
inline std::unexpected<Error> fail(std::string file, std::string field, std::string what) {
  return std::unexpected(Error{std::move(file), std::move(field), std::move(what)});
}

}  // namespace fluxgs
