#include "io/byte_window.h"

#include <algorithm>

namespace fluxgs::io {
namespace {

constexpr std::size_t kWindow = std::size_t{1} << 20;

}  // namespace

ByteWindow::ByteWindow(const ByteSource& source, std::uint64_t begin)
    : source_(source), at_(begin), window_at_(begin) {}

std::span<const std::byte> ByteWindow::ahead(std::size_t least) {
  const std::uint64_t end = window_at_ + window_.size();
  const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(least, left()));
  if (at_ >= window_at_ && at_ + wanted <= end)
    return window_.subspan(static_cast<std::size_t>(at_ - window_at_));
  const auto size =
      static_cast<std::size_t>(std::min<std::uint64_t>(std::max(least, kWindow), left()));
  const auto read = source_.read(at_, size, room_);
  if (!read) {
    error_ = read.error();
    at_ = window_at_ = source_.size();
    window_ = {};
    return {};
  }
  window_at_ = at_;
  window_ = *read;
  return window_;
}

bool ByteWindow::skip(std::uint64_t bytes) {
  if (bytes > left()) return false;
  at_ += bytes;
  return true;
}

}  // namespace fluxgs::io
