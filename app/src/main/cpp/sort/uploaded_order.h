// An order that was made on the CPU, on its way to the GPU.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "gl/expected_chain.h"
#include "sort/sorter.h"

namespace fluxgs::sort {

/// The order and the count that a Sorter offers, written from the CPU.
class UploadedOrder {
 public:
  UploadedOrder() = default;

  /// Room for `entries` indices.
  static Expected<UploadedOrder> create(gl::Api& api, std::size_t entries, OrderPlace place) {
    UploadedOrder made;
    made.api_ = &api;
    auto done =
        place == OrderPlace::texture ? made.create_texture(entries) : made.create_buffers(entries);
    if (!done) return std::unexpected(done.error());
    return made;
  }

  /// Precondition: no more indices than there is room for.
  void write(std::span<const std::uint32_t> indices) {
    const auto number = static_cast<std::uint32_t>(indices.size());
    if (texture_) {
      texture_->indices.write(*api_, 0, std::as_bytes(indices));
      texture_->count = number;
      return;
    }
    if (!indices.empty()) order_.write(0, std::as_bytes(indices));
    count_.write(0, std::as_bytes(std::span(&number, 1)));
  }

  const gl::Buffer& order() const { return order_; }
  const gl::Buffer& count() const { return count_; }
  const OrderTexture* texture() const { return texture_ ? &*texture_ : nullptr; }

 private:
  Expected<void> create_buffers(std::size_t entries) {
    constexpr std::uint32_t kNone = 0;
    return gl::chain(
        [&] {
          return gl::assign_or_error(
              gl::Buffer::create(*api_, sizeof(std::uint32_t) * entries, nullptr, GL_DYNAMIC_DRAW),
              order_);
        },
        [&] {
          return gl::assign_or_error(
              gl::Buffer::create(*api_, sizeof kNone, &kNone, GL_DYNAMIC_DRAW), count_);
        });
  }

  Expected<void> create_texture(std::size_t entries) {
    return gl::assign_or_error(gl::TexelArray::create(*api_, GL_R32UI, entries),
                               texture_.emplace().indices);
  }

  gl::Api* api_ = nullptr;
  gl::Buffer order_, count_;
  std::optional<OrderTexture> texture_;
};

}  // namespace fluxgs::sort
