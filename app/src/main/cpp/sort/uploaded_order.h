// An order that was made on the CPU, on its way to the GPU.
#pragma once

#include <cstdint>
#include <span>

#include "gl/buffer.h"
#include "gl/expected_chain.h"

namespace fluxgs::sort {

/// The two buffers that every Sorter offers, written from the CPU.
struct UploadedOrder {
  gl::Buffer order, count;

  /// Room for `entries` indices.
  static Expected<UploadedOrder> create(gl::Api& api, std::size_t entries) {
    UploadedOrder made;
    constexpr std::uint32_t kNone = 0;
    auto done = gl::chain(
        [&] {
          return gl::assign_or_error(
              gl::Buffer::create(api, sizeof(std::uint32_t) * entries, nullptr, GL_DYNAMIC_DRAW),
              made.order);
        },
        [&] {
          return gl::assign_or_error(gl::Buffer::create(api, sizeof kNone, &kNone, GL_DYNAMIC_DRAW),
                                     made.count);
        });
    if (!done) return std::unexpected(done.error());
    return made;
  }

  /// Precondition: no more indices than there is room for.
  void write(std::span<const std::uint32_t> indices) {
    const auto number = static_cast<std::uint32_t>(indices.size());
    if (!indices.empty()) order.write(0, std::as_bytes(indices));
    count.write(0, std::as_bytes(std::span(&number, 1)));
  }
};

}  // namespace fluxgs::sort
