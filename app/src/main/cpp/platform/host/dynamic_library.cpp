#include "platform/host/dynamic_library.h"

#include <dlfcn.h>

namespace fluxgs::host {

Expected<DynamicLibrary> DynamicLibrary::open(std::initializer_list<std::string> names,
                                              const std::string& advice) {
  DynamicLibrary library;
  for (const std::string& name : names) {
    library.handle_ = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library.handle_) return library;
  }
  const char* reason = dlerror();
  return fail(
      *names.begin(), "",
      "cannot be loaded (" + std::string(reason ? reason : "no reason given") + "); " + advice);
}

void* DynamicLibrary::symbol(const char* name) const { return dlsym(handle_, name); }

}  // namespace fluxgs::host
