// Allocation of a SplatCloud with errors as values, and checks before it is written.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/splat_cloud.h"

namespace fluxgs::io {

/// Make room for `count` splats; out of memory is an error that says how many bytes were wanted.
Expected<SplatCloud> allocate_cloud(std::size_t count, int sh_degree, const std::string& name);

/// The same for splats that are appended to `cloud`, of its degree.
Expected<void> reserve_cloud(std::size_t count, const std::string& name, SplatCloud& cloud);

/// A zeroed buffer; out of memory is an error that says how many bytes were wanted.
Expected<std::vector<std::byte>> allocate_bytes(std::size_t size, const std::string& name);

/// `cloud` itself if its arrays agree in size and all splats are finite; a copy of the finite
/// splats in `storage` if some are not; an error if the arrays disagree.
Expected<const SplatCloud*> writable_cloud(const SplatCloud& cloud, SplatCloud& storage,
                                           const std::string& name);

}  // namespace fluxgs::io
