// Loads libraries while the program runs, so that it starts on machines without them.
#pragma once

#include <initializer_list>
#include <string>

#include "fluxgs/error.h"

namespace fluxgs::host {

/// A loaded library. Never unloaded: drivers leave threads and thread-local data behind that a
/// dlclose would pull the code away from.
class DynamicLibrary {
 public:
  DynamicLibrary() = default;

  /// Tries the names in turn. `advice` ends the error text, e.g. "install the package libegl1".
  static Expected<DynamicLibrary> open(std::initializer_list<std::string> names,
                                       const std::string& advice);

  /// The address of a symbol, or null.
  void* symbol(const char* name) const;

  template <class Function>
  void load(Function& function, const char* name) const {
    function = reinterpret_cast<Function>(symbol(name));
  }

 private:
  void* handle_ = nullptr;
};

}  // namespace fluxgs::host
