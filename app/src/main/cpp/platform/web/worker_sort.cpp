#include "platform/web/worker_sort.h"

#include <emscripten.h>

namespace fluxgs::web {
namespace {

WorkerSort* the_one = nullptr;
int scenes = 0;

// clang-format off
EM_JS(void, post_positions, (int scene, const void* positions, size_t bytes), {
  Module['sorter'].positions(scene, HEAPU8.slice(positions, positions + bytes));
});
EM_JS(void, post_view, (int scene, double ticket, const void* view, size_t bytes), {
  Module['sorter'].view(scene, ticket, HEAPU8.slice(view, view + bytes));
});
// clang-format on

}  // namespace

WorkerSort::WorkerSort(const std::vector<glm::vec3>& positions)
    : scene_(++scenes), size_(positions.size()) {
  the_one = this;
  post_positions(scene_, positions.data(), sizeof(glm::vec3) * size_);
}

WorkerSort::~WorkerSort() {
  if (the_one == this) the_one = nullptr;
}

WorkerSort* WorkerSort::current() { return the_one; }

std::uint64_t WorkerSort::request(const sort::SortView& view) {
  post_view(scene_, static_cast<double>(++last_ticket_), &view, sizeof view);
  return last_ticket_;
}

void* WorkerSort::room(int scene, std::size_t count) {
  if (scene != scene_ || count > size_) return nullptr;
  for (auto& buffer : pool_) {
    if (buffer.use_count() > 1) continue;
    if (!buffer) buffer = std::make_shared<sort::IndexBuffer>();
    buffer->indices.resize(size_);
    writing_ = buffer;
    return buffer->indices.data();
  }
  return nullptr;
}

void WorkerSort::came(std::uint64_t ticket, std::uint32_t count) {
  writing_->count = count;
  writing_->ticket = ticket;
  newest_ = std::move(writing_);
}

}  // namespace fluxgs::web
