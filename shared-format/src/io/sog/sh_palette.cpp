#include "io/sog/sh_palette.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>

namespace fluxgs::io {
namespace {

constexpr int kPowerIterations = 3;  // for a principal axis
constexpr int kLloydIterations = 3;
constexpr std::size_t kNeighbours = 64;  // cells on either side that a vector may move to

// A range of `order`, the vectors of a cell.
struct Cell {
  std::size_t begin = 0, end = 0;
  double error = 0;  // sum of the squared distances from the mean

  bool operator<(const Cell& other) const {  // the largest error first, then the first range
    return error != other.error ? error < other.error : begin > other.begin;
  }
};

class Splitter {
 public:
  Splitter(std::span<const float> vectors, std::size_t dimensions)
      : vectors_(vectors),
        dimensions_(dimensions),
        order_(vectors.size() / dimensions),
        mean_(dimensions),
        axis_(dimensions),
        next_(dimensions) {
    std::iota(order_.begin(), order_.end(), 0U);
  }

  // The cells, in the order of their ranges.
  std::vector<Cell> split(std::size_t most, const std::function<void(double)>& progress) {
    std::priority_queue<Cell> cells;
    cells.push(measured({0, order_.size()}));
    while (cells.size() < most && cells.top().error > 0) {
      const Cell cell = cells.top();
      cells.pop();
      const std::size_t middle = halve(cell);
      const bool whole = middle == cell.begin || middle == cell.end;
      if (whole) {
        cells.push({cell.begin, cell.end, 0});  // vectors that differ by rounding alone
        continue;
      }
      cells.push(measured({cell.begin, middle}));
      cells.push(measured({middle, cell.end}));
      if (cells.size() % 1024 == 0)
        progress(static_cast<double>(cells.size()) / static_cast<double>(most));
    }
    std::vector<Cell> result;
    for (; !cells.empty(); cells.pop()) result.push_back(cells.top());
    std::ranges::sort(result, {}, &Cell::begin);
    return result;
  }

  std::span<const std::uint32_t> order() const { return order_; }

 private:
  const float* at(std::size_t i) const { return vectors_.data() + order_[i] * dimensions_; }

  void find_mean(const Cell& cell) {
    std::ranges::fill(mean_, 0.0F);
    for (std::size_t i = cell.begin; i < cell.end; ++i)
      for (std::size_t d = 0; d < dimensions_; ++d) mean_[d] += at(i)[d];
    for (float& m : mean_) m /= static_cast<float>(cell.end - cell.begin);
  }

  Cell measured(Cell cell) {
    find_mean(cell);
    for (std::size_t i = cell.begin; i < cell.end; ++i) {
      float sum = 0;
      for (std::size_t d = 0; d < dimensions_; ++d) {
        const float off = at(i)[d] - mean_[d];
        sum += off * off;
      }
      cell.error += double{sum};
    }
    if (cell.end - cell.begin == 1) cell.error = 0;
    return cell;
  }

  // The product of an offset from the mean with the axis.
  float along(const float* vector) const {
    float sum = 0;
    for (std::size_t d = 0; d < dimensions_; ++d) sum += (vector[d] - mean_[d]) * axis_[d];
    return sum;
  }

  // The power method on the covariance, from the axis of the variances.
  void find_axis(const Cell& cell) {
    std::ranges::fill(axis_, 0.0F);
    for (std::size_t i = cell.begin; i < cell.end; ++i)
      for (std::size_t d = 0; d < dimensions_; ++d) {
        const float off = at(i)[d] - mean_[d];
        axis_[d] += off * off;
      }
    for (int k = 0; k < kPowerIterations; ++k) {
      normalize_axis();
      std::ranges::fill(next_, 0.0F);
      for (std::size_t i = cell.begin; i < cell.end; ++i) {
        const float* vector = at(i);
        const float weight = along(vector);
        for (std::size_t d = 0; d < dimensions_; ++d) next_[d] += weight * (vector[d] - mean_[d]);
      }
      if (std::ranges::any_of(next_, [](float v) { return v != 0; })) std::swap(axis_, next_);
    }
  }

  void normalize_axis() {
    const float most =
        std::abs(*std::ranges::max_element(axis_, {}, [](float v) { return std::abs(v); }));
    for (float& v : axis_) v /= most > 0 ? most : 1;
  }

  // Vectors on one side of the mean before those on the other; where the latter begin.
  std::size_t halve(const Cell& cell) {
    find_mean(cell);
    find_axis(cell);
    const auto range =
        std::ranges::subrange(order_.begin() + static_cast<std::ptrdiff_t>(cell.begin),
                              order_.begin() + static_cast<std::ptrdiff_t>(cell.end));
    const auto rest = std::ranges::stable_partition(
        range, [&](std::uint32_t i) { return along(vectors_.data() + i * dimensions_) < 0; });
    return cell.end - static_cast<std::size_t>(rest.size());
  }

  std::span<const float> vectors_;
  std::size_t dimensions_;
  std::vector<std::uint32_t> order_;
  std::vector<float> mean_, axis_, next_;
};

// The means of the vectors of each label; those of labels without any stay.
void find_means(std::span<const float> vectors, std::size_t dimensions, ShPalette& palette) {
  const std::size_t entries = palette.entries.size() / dimensions;
  std::vector<std::uint32_t> counts(entries);
  for (const std::uint32_t label : palette.labels) ++counts[label];
  for (std::size_t k = 0; k < entries; ++k)
    if (counts[k] > 0) std::fill_n(palette.entries.data() + k * dimensions, dimensions, 0.0F);
  for (std::size_t i = 0; i < palette.labels.size(); ++i) {
    float* entry = palette.entries.data() + palette.labels[i] * dimensions;
    for (std::size_t d = 0; d < dimensions; ++d) entry[d] += vectors[i * dimensions + d];
  }
  for (std::size_t k = 0; k < entries; ++k)
    for (std::size_t d = 0; counts[k] > 0 && d < dimensions; ++d)
      palette.entries[k * dimensions + d] /= static_cast<float>(counts[k]);
}

float squared_distance(const float* a, const float* b, std::size_t dimensions) {
  float sum = 0;
  for (std::size_t d = 0; d < dimensions; ++d) sum += (a[d] - b[d]) * (a[d] - b[d]);
  return sum;
}

// Moves vector i to the nearest entry beside its own.
void move_to_nearest(std::span<const float> vectors, std::size_t dimensions, std::size_t i,
                     ShPalette& palette) {
  const std::size_t entries = palette.entries.size() / dimensions, own = palette.labels[i];
  const std::size_t first = own - std::min(own, kNeighbours),
                    last = std::min(entries, own + kNeighbours + 1);
  const float* vector = vectors.data() + i * dimensions;
  const auto distance = [&](std::size_t k) {
    return squared_distance(vector, palette.entries.data() + k * dimensions, dimensions);
  };
  float least = distance(own);
  for (std::size_t k = first; k < last && least > 0; ++k)
    if (const float d = distance(k); d < least)
      least = d, palette.labels[i] = static_cast<std::uint32_t>(k);
}

}  // namespace

ShPalette make_sh_palette(std::span<const float> vectors, std::size_t dimensions, std::size_t most,
                          const std::function<void(double)>& progress) {
  ShPalette palette;
  const std::size_t count = vectors.size() / dimensions;
  palette.labels.resize(count);
  if (count == 0) return palette;
  constexpr double kSplitting = 0.4;  // of the time
  Splitter splitter(vectors, dimensions);
  const auto cells = splitter.split(most, [&](double part) { progress(kSplitting * part); });
  palette.entries.resize(cells.size() * dimensions);
  for (std::size_t k = 0; k < cells.size(); ++k)
    for (std::size_t i = cells[k].begin; i < cells[k].end; ++i)
      palette.labels[splitter.order()[i]] = static_cast<std::uint32_t>(k);
  find_means(vectors, dimensions, palette);
  for (int round = 0; round < kLloydIterations; ++round) {
    for (std::size_t i = 0; i < count; ++i) {
      move_to_nearest(vectors, dimensions, i, palette);
      if (i % 8192 == 0)
        progress(kSplitting + (1 - kSplitting) *
                                  (round + static_cast<double>(i) / static_cast<double>(count)) /
                                  kLloydIterations);
    }
    find_means(vectors, dimensions, palette);
  }
  return palette;
}

}  // namespace fluxgs::io
