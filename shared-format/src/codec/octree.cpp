#include "codec/octree.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "codec/rans.h"

namespace fluxgs::codec {
namespace {

using Numbers = std::vector<std::int32_t>;

unsigned levels_of(std::span<const Cell> cells) {
  std::uint32_t all = 0;
  for (const Cell& cell : cells) all |= static_cast<std::uint32_t>(cell.x | cell.y | cell.z);
  return static_cast<unsigned>(std::bit_width(all));
}

/// The child of its node that a cell is in, `shift` levels above the cells.
unsigned child_of(const Cell& cell, unsigned shift) {
  const auto bit = [shift](std::int32_t v) { return static_cast<unsigned>(v >> shift & 1); };
  return bit(cell.x) | bit(cell.y) << 1 | bit(cell.z) << 2;
}

/// A bit for each child that is there, of all nodes whose children are `shift` levels above the
/// cells.
Numbers children_at(std::span<const Cell> cells, unsigned shift) {
  const Cell up(static_cast<int>(shift) + 1);
  Numbers children;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i == 0 || (cells[i] >> up) != (cells[i - 1] >> up)) children.push_back(0);
    children.back() |= 1 << child_of(cells[i], shift);
  }
  return children;
}

/// For each distinct cell, the number of further ones equal to it.
Numbers repeats_of(std::span<const Cell> cells) {
  Numbers repeats;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (i > 0 && cells[i] == cells[i - 1])
      ++repeats.back();
    else
      repeats.push_back(0);
  return repeats;
}

std::unexpected<Error> damaged_octree(const char* what) { return fail("", "positions", what); }

/// Bits that are set of the lowest eight, as compilers can vectorise it.
std::uint32_t bits_in(std::int32_t byte) {
  auto bits = static_cast<std::uint32_t>(byte);
  bits -= bits >> 1 & 0x55;
  bits = (bits & 0x33) + (bits >> 2 & 0x33);
  return (bits + (bits >> 4)) & 0xf;
}

/// The number of children in all. Nothing where a node has none, or more than `most` are there.
std::optional<std::size_t> count_children(std::span<const std::int32_t> children,
                                          std::size_t most) {
  std::size_t sum = 0;
  std::int32_t least = 255, largest = 1;
  for (const std::int32_t bits : children) {
    least = std::min(least, bits);
    largest = std::max(largest, bits);
    sum += bits_in(bits);
  }
  const bool sound = least >= 1 && largest <= 255 && sum <= most;
  return sound ? std::optional(sum) : std::nullopt;
}

/// Makes the nodes at the front of `cells` their children, of which there are `count`. Begins with
/// the last: what a node becomes lies where it was or behind that.
void descend(std::span<const std::int32_t> children, std::size_t count, std::span<Cell> cells) {
  for (std::size_t i = children.size(); i-- > 0;) {
    const std::int32_t x = 2 * cells[i].x, y = 2 * cells[i].y, z = 2 * cells[i].z;
    for (auto bits = static_cast<std::uint32_t>(children[i]); bits != 0;) {
      const auto child = static_cast<std::int32_t>(std::bit_width(bits)) - 1;
      bits ^= 1u << child;
      cells[--count] = {x + (child & 1), y + (child >> 1 & 1), z + (child >> 2)};
    }
  }
}

/// The same for cells that are there several times. False if that makes others than all of them.
bool repeat(std::span<const std::int32_t> repeats, std::span<Cell> cells) {
  std::size_t sum = repeats.size();
  for (const std::int32_t more : repeats) {
    if (more < 0 || static_cast<std::size_t>(more) > cells.size() - sum) return false;
    sum += static_cast<std::size_t>(more);
  }
  if (sum != cells.size()) return false;
  for (std::size_t i = repeats.size(); i-- > 0;) {
    const Cell cell = cells[i];
    for (std::int32_t k = 0; k <= repeats[i]; ++k) cells[--sum] = cell;
  }
  return true;
}

}  // namespace

void encode_octree(std::span<const Cell> cells, Bytes& out) {
  const unsigned levels = levels_of(cells);
  put(out, static_cast<std::uint8_t>(levels));
  std::vector<Numbers> channels;
  for (unsigned level = 0; level < levels; ++level)
    channels.push_back(children_at(cells, levels - 1 - level));
  channels.push_back(repeats_of(cells));
  encode_values(channels, out);
}

Expected<void> decode_octree(ByteReader& in, std::span<Cell> cells) {
  const auto levels = in.take<std::uint8_t>();
  if (!levels) return damaged_octree("are cut off");
  if (*levels > kOctreeLevels)
    return fail("", "positions",
                fmt::format("have {} levels, expected {} at most", *levels, kOctreeLevels));
  auto decoder = ValueDecoder::open(in, *levels + std::size_t{1});
  if (!decoder) return fail("", "positions", decoder.error().what);
  std::vector<std::int32_t> room(cells.size());
  std::size_t nodes = 1;
  cells[0] = Cell(0);
  for (unsigned level = 0; level < *levels; ++level) {
    const auto children = std::span(room).first(nodes);
    if (auto ok = decoder->next(children); !ok) return fail("", "positions", ok.error().what);
    const auto count = count_children(children, cells.size());
    if (!count) return damaged_octree("are damaged: a node without children, or too many cells");
    descend(children, *count, cells);
    nodes = *count;
  }
  const auto repeats = std::span(room).first(nodes);
  if (auto ok = decoder->next(repeats); !ok) return fail("", "positions", ok.error().what);
  if (!repeat(repeats, cells))
    return fail("", "positions",
                fmt::format("hold another number of splats, expected {}", cells.size()));
  return {};
}

}  // namespace fluxgs::codec
