// The trainer's only way to use several cores: work cut into pieces whose borders do not depend on
// the number of threads, so that results do not either.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace fluxgs {

class Threads {
 public:
  /// `count` threads; 0 takes every core.
  explicit Threads(int count);
  ~Threads();
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

  int count() const;

  /// Calls work(begin, end) for the pieces [0, piece), [piece, 2·piece), … of [0, size), in no
  /// particular order. The first exception that a piece throws is thrown again here.
  void for_pieces(std::size_t size, std::size_t piece,
                  const std::function<void(std::size_t, std::size_t)>& work) const;

 private:
  struct Arena;
  std::unique_ptr<Arena> arena_;
};

}  // namespace fluxgs
