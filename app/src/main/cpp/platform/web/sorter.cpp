// The functions of the sorting worker.
#include <emscripten.h>

#include <optional>
#include <vector>

#include "sort/depth_sort.h"

namespace fluxgs::web {
namespace {

struct SortWorker {
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> order;
  std::optional<sort::DepthSort> sort;
  sort::SortView view;
};

SortWorker& sort_worker() {
  static SortWorker one;
  return one;
}

}  // namespace
}  // namespace fluxgs::web

extern "C" {

/// Room for the positions of another scene, three floats each.
EMSCRIPTEN_KEEPALIVE void* flux_sort_positions(std::size_t count) {
  auto& worker = fluxgs::web::sort_worker();
  worker.sort.reset();
  worker.positions.resize(count);
  worker.order.resize(count);
  return worker.positions.data();
}
/// They were written.
EMSCRIPTEN_KEEPALIVE void flux_sort_begin() {
  auto& worker = fluxgs::web::sort_worker();
  worker.sort.emplace(std::move(worker.positions));
}
/// Room for a view, in the bytes of the page's instance of the module.
EMSCRIPTEN_KEEPALIVE void* flux_sort_view() { return &fluxgs::web::sort_worker().view; }
/// Sorts; returns how many splats are listed.
EMSCRIPTEN_KEEPALIVE std::uint32_t flux_sort() {
  auto& worker = fluxgs::web::sort_worker();
  return worker.sort->sort(worker.view, worker.order);
}
EMSCRIPTEN_KEEPALIVE const void* flux_sort_order() {
  return fluxgs::web::sort_worker().order.data();
}
}
