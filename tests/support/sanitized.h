#pragma once

namespace fluxgs::test {

/// True in a build with AddressSanitizer, where tests do less: it looks for mistakes, not for
/// numbers, and takes its time.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace fluxgs::test
