// The entry of libFuzzer (https://llvm.org/docs/LibFuzzer.html) for the one target linked in.
#include "harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fluxgs::fuzz;
  const auto run = targets().front().run;
  return run({reinterpret_cast<const std::byte*>(data), size}) == Worth::keep ? 0 : -1;
}
