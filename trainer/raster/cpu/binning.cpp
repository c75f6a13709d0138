#include "trainer/raster/cpu/binning.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

namespace fluxgs {
namespace {

struct DepthKey {
  std::uint32_t key, index;
};

constexpr int kDigitBits = 11;  // three passes for 32 bits
constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;

/// Stable least-significant-digit radix sort.
void radix_sort(std::vector<DepthKey>& keys) {
  std::vector<DepthKey> other(keys.size());
  std::array<std::array<std::uint32_t, kDigits>, 3> counts{};
  const auto digit = [](std::uint32_t key, std::size_t pass) {
    return (key >> (pass * kDigitBits)) & (kDigits - 1);
  };
  for (const DepthKey& k : keys)
    for (std::size_t pass = 0; pass < 3; ++pass) ++counts[pass][digit(k.key, pass)];
  for (std::size_t pass = 0; pass < 3; ++pass) {
    std::uint32_t next = 0;
    for (std::uint32_t& c : counts[pass]) next += std::exchange(c, next);
    for (const DepthKey& k : keys) other[counts[pass][digit(k.key, pass)]++] = k;
    keys.swap(other);
  }
}

// How the depth order is cut for threads: fixed, so that results never depend on their number.
constexpr std::size_t kMaxChunks = 64, kMinChunk = 512;
constexpr std::size_t kAhead = 4;  // splats lie in no order: how far ahead one is asked for

std::size_t chunk_size(std::size_t count) {
  return std::max(kMinChunk, (count + kMaxChunks - 1) / kMaxChunks);
}

/// An upper bound of the tiles that a splat's box meets.
std::size_t tiles_in_box(const ProjectedSplat& s, const TileLists& lists) {
  const auto span = [](float half, int tiles) {
    const float wanted = (half + 1.0f) * (2.0f / kTileSize) + 3.0f;
    return static_cast<std::size_t>(std::min(wanted, static_cast<float>(tiles)));
  };
  return span(s.half_width, lists.tiles_x) * span(s.half_height, lists.tiles_y);
}

}  // namespace

void sort_by_depth(const std::vector<ProjectedSplat>& splats,
                   const std::vector<std::uint8_t>& visible, TileLists& lists) {
  std::vector<DepthKey> keys;
  keys.reserve(splats.size());
  for (std::uint32_t i = 0; i < splats.size(); ++i)  // depths are positive: their bits are in order
    if (visible[i]) keys.push_back({std::bit_cast<std::uint32_t>(splats[i].depth), i});
  radix_sort(keys);
  lists.order.resize(keys.size());
  std::ranges::transform(keys, lists.order.begin(), &DepthKey::index);
}

void Binner::list_tiles(const RasterKernels& kernels, const std::vector<ProjectedSplat>& splats,
                        const RasterConstants& constants, TileLists& lists, std::size_t begin,
                        std::size_t end, Chunk& chunk) {
  chunk.used = 0;
  chunk.next.assign(lists.tiles(), 0);
  for (std::size_t k = begin; k < end; ++k) {
    if (k + kAhead < end) __builtin_prefetch(&splats[lists.order[k + kAhead]]);
    const ProjectedSplat& s = splats[lists.order[k]];
    const std::size_t room = chunk.used + tiles_in_box(s, lists) + 1;
    if (chunk.bins.size() < room) chunk.bins.resize(room + room / 2);
    const std::uint32_t count = kernels.bin(splats.data(), lists.order[k], constants, lists.tiles_x,
                                            lists.tiles_y, chunk.bins.data() + chunk.used);
    lists.first_slot[k + 1] = count;
    chunk.used += count;
  }
  for (std::size_t b = 0; b < chunk.used; ++b) ++chunk.next[chunk.bins[b].tile];
}

void Binner::place_chunks(TileLists& lists) {
  for (std::size_t k = 1; k < lists.first_slot.size(); ++k)
    lists.first_slot[k] += lists.first_slot[k - 1];
  lists.first_entry.resize(lists.tiles() + 1);
  std::uint32_t next = 0;
  for (std::size_t tile = 0; tile < lists.tiles(); ++tile) {
    lists.first_entry[tile] = next;
    for (Chunk& chunk : chunks_) next += std::exchange(chunk.next[tile], next);
  }
  lists.first_entry.back() = next;
  lists.entries.resize(next);
}

void Binner::fill(TileLists& lists, std::uint32_t first_slot, Chunk& chunk) {
  for (std::size_t b = 0; b < chunk.used; ++b) {
    const TileBin& bin = chunk.bins[b];
    lists.entries[chunk.next[bin.tile]++] = {bin.splat, first_slot + static_cast<std::uint32_t>(b),
                                             bin.blocks};
  }
}

void Binner::run(const Threads& threads, const RasterKernels& kernels,
                 const std::vector<ProjectedSplat>& splats, const RasterConstants& constants,
                 int width, int height, TileLists& lists) {
  lists.tiles_x = (width + kTileSize - 1) / kTileSize;
  lists.tiles_y = (height + kTileSize - 1) / kTileSize;
  const std::size_t count = lists.order.size(), piece = chunk_size(count);
  lists.first_slot.resize(count + 1);
  lists.first_slot[0] = 0;
  chunks_.resize((count + piece - 1) / piece);
  threads.for_pieces(count, piece, [&](std::size_t begin, std::size_t end) {
    list_tiles(kernels, splats, constants, lists, begin, end, chunks_[begin / piece]);
  });
  place_chunks(lists);
  threads.for_pieces(count, piece, [&](std::size_t begin, std::size_t) {
    fill(lists, lists.first_slot[begin], chunks_[begin / piece]);
  });
}

}  // namespace fluxgs
