#include "tools/fluxgs/terminal/instruction_set.h"

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "fluxgs/sanitize.h"
#include "trainer/core/isa.h"

namespace fluxgs::cli {

Expected<void> check_instruction_set() {
  const char* const wanted = std::getenv("FLUXGS_ISA");
  std::vector<std::string_view> names;
  for (const Isa isa : available_isas()) names.push_back(name_of(isa));
  if (wanted == nullptr || std::ranges::count(names, std::string_view(wanted)) > 0) return {};
  return fail("", "FLUXGS_ISA",
              fmt::format("\"{}\" is not of this processor; expected one of {}",
                          sanitized(wanted, 40), fmt::join(names, ", ")));
}

}  // namespace fluxgs::cli
