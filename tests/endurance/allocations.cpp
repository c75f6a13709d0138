#include "allocations.h"

#include <malloc.h>

#include <algorithm>
#include <cstdlib>
#include <new>

#include "unit/renderer/gl_faults.h"

#if !defined(__SANITIZE_ADDRESS__)  // which has its own, and insists on them
namespace {

using fluxgs::test::allocations;

void* allocate(std::size_t bytes) {
  if (!fluxgs::test::inside_driver) ++allocations.count;
  void* const memory = std::malloc(bytes > 0 ? bytes : 1);
  if (memory == nullptr) throw std::bad_alloc();
  const long held = allocations.bytes += static_cast<long>(::malloc_usable_size(memory));
  long most = allocations.max_bytes;
  while (most < held && !allocations.max_bytes.compare_exchange_weak(most, held)) {
  }
  return memory;
}

void release(void* memory) {
  if (memory == nullptr) return;
  allocations.bytes -= static_cast<long>(::malloc_usable_size(memory));
  std::free(memory);
}

}  // namespace

void* operator new(std::size_t bytes) { return allocate(bytes); }
void* operator new[](std::size_t bytes) { return allocate(bytes); }
void operator delete(void* memory) noexcept { release(memory); }
void operator delete[](void* memory) noexcept { release(memory); }
void operator delete(void* memory, std::size_t) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t) noexcept { release(memory); }
#endif
