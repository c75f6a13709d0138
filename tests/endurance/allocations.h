// Counts calls of operator new by all threads, outside of calls of the driver. A driver's own
// threads would count, too.
#pragma once

#include <atomic>

namespace fluxgs::test {

struct Allocations {
  std::atomic<long> count = 0;      ///< so far
  std::atomic<long> bytes = 0;      ///< that are held now, by drivers, too
  std::atomic<long> max_bytes = 0;  ///< that were held at once; set it to begin anew
};

inline Allocations allocations;

}  // namespace fluxgs::test
