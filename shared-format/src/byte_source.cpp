#include "fluxgs/byte_source.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <exception>
#include <system_error>

#include <fmt/format.h>

namespace fluxgs {

Expected<std::span<const std::byte>> FileBytes::read(std::uint64_t at, std::size_t count,
                                                     std::vector<std::byte>& room) const {
  constexpr std::size_t kMost = std::size_t{1} << 30;  // some systems refuse more than 2^31
  try {
    if (room.size() < count) room.resize(count);
  } catch (const std::exception&) {  // bad_alloc, or length_error beyond what a vector can count
    return fail(name_, "memory", fmt::format("out of memory reading {} bytes", count));
  }
  for (std::size_t done = 0; done < count;) {
    const auto got = ::pread(descriptor_, room.data() + done, std::min(kMost, count - done),
                             static_cast<off_t>(begin_ + at + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return fail(name_, "read", std::generic_category().message(errno));
    if (got == 0)
      return fail(
          name_, "read",
          fmt::format("ended after {} of {} bytes: it was cut, or is gone", at + done, size_));
    done += static_cast<std::size_t>(got);
  }
  return std::span<const std::byte>(room).first(count);
}

}  // namespace fluxgs
