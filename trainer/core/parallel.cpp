#include "trainer/core/parallel.h"

#include <algorithm>
#include <optional>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace fluxgs {

struct Threads::Arena {
  tbb::task_arena arena;
  // More threads than cores are allowed where someone asks for them
  std::optional<tbb::global_control> allowance;
  explicit Arena(int count) : arena(count > 0 ? count : tbb::task_arena::automatic) {
    if (count > tbb::info::default_concurrency())
      allowance.emplace(tbb::global_control::max_allowed_parallelism,
                        static_cast<std::size_t>(count));
  }
};

Threads::Threads(int count) : arena_(std::make_unique<Arena>(count)) {}
Threads::~Threads() = default;

int Threads::count() const { return arena_->arena.max_concurrency(); }

void Threads::for_pieces(std::size_t size, std::size_t piece,
                         const std::function<void(std::size_t, std::size_t)>& work) const {
  const std::size_t pieces = (size + piece - 1) / piece;
  if (pieces == 0) return;
  if (pieces == 1) return work(0, size);
  arena_->arena.execute([&] {
    tbb::parallel_for(
        std::size_t{0}, pieces,
        [&](std::size_t i) { work(i * piece, std::min(size, (i + 1) * piece)); },
        tbb::simple_partitioner());
  });
}

}  // namespace fluxgs
