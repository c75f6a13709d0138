// Project → sort → bin → blend tiles, and back: the CPU backend of Rasterizer.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "trainer/raster/cpu/binning.h"
#include "trainer/raster/cpu/raster_kernels.h"
#include "trainer/raster/rasterizer.h"

namespace fluxgs {
namespace {

constexpr std::size_t kSplatPiece = 1024;  // splats per piece of parallel work

RasterConstants constants_of(const RenderOptions& o) {
  const auto f = [](double v) { return static_cast<float>(v); };
  return {f(o.alpha_max),         f(std::log2(o.alpha_max)),
          f(o.alpha_min),         f(std::log2(o.alpha_min)),
          f(o.transmittance_min), {f(o.background.x), f(o.background.y), f(o.background.z)}};
}

class CpuRasterizer final : public Rasterizer {
 public:
  CpuRasterizer(const Threads& threads, Profiler& profiler, const CpuRasterizerOptions& options)
      : threads_(threads),
        profiler_(profiler),
        kernels_(raster_kernels(options.isa)),
        count_pairs_(options.count_pixel_pairs) {}

  const std::vector<std::uint8_t>& find_visible(const PlanarFloats& parameters,
                                                const Camera& camera,
                                                const RenderOptions& options) override {
    start(parameters, camera, options);
    sh_degree_ = 0;
    project(parameters);
    return visible_;
  }

  void forward(const PlanarFloats& parameters, const Camera& camera,
               const RenderOptions& options) override {
    start(parameters, camera, options);
    project(parameters);
    {
      ProfileScope scope(profiler_, "sort");
      sort_by_depth(splats_, visible_, lists_);
      binner_.run(threads_, kernels_, splats_, constants_, camera.width, camera.height, lists_);
    }
    blend(camera.width, camera.height);
  }

  void backward(const PlanarFloats& parameters, const PlanarImage& color_gradient,
                const PlanarImage* transmittance_gradient) override {
    backpropagate_tiles(color_gradient, transmittance_gradient);
    ProfileScope scope(profiler_, "gradient");
    sum_pairs();
    chain_rule(parameters);
  }

  const PlanarFloats& score(const PlanarImage& maps, ScoreWeight weight) override {
    ProfileScope scope(profiler_, "score");
    replay_tiles(pair_scores_, [&](const TileArgs& tile) {
      kernels_.score({tile, maps.plane(0), maps.channels() > 2, weight, pair_scores_.data()});
    });
    scores_ = PlanarFloats(score::count, splats_.size());
    sum_fields(pair_scores_, scores_);
    return scores_;
  }

  const PlanarFloats& removal(const PlanarImage& target) override {
    ProfileScope scope(profiler_, "score");
    replay_tiles(pair_removals_, [&](const TileArgs& tile) {
      kernels_.removal({tile, target.plane(0), target.channels() > 3, pair_removals_.data()});
    });
    removals_ = PlanarFloats(removal::count, splats_.size());
    sum_fields(pair_removals_, removals_);
    return removals_;
  }

  const PlanarImage& color() const override { return color_; }
  const PlanarImage& transmittance() const override { return transmittance_; }
  const PlanarFloats& gradient() const override { return gradient_; }
  PlanarFloats& gradient() override { return gradient_; }
  const float* center_gradient() const override { return center_gradient_.row(0); }
  const std::vector<std::uint8_t>& visible() const override { return visible_; }
  float screen_radius(std::size_t i) const override {
    return std::max(splats_[i].half_width, splats_[i].half_height);
  }
  RasterCounts counts() const override {
    return {lists_.order.size(), lists_.entries.size(), pixel_pairs_};
  }
  std::uint64_t rejected_gradients() const override { return rejected_; }

 private:
  void start(const PlanarFloats& parameters, const Camera& camera, const RenderOptions& options) {
    view_ = math::make_view<float>(camera, options);
    constants_ = constants_of(options);
    sh_degree_ = std::min(options.sh_degree, sh_degree_of(parameters));
  }

  void project(const PlanarFloats& parameters) {
    ProfileScope scope(profiler_, "project");
    splats_.resize(parameters.size());
    visible_.assign(parameters.stride() + PlanarFloats::kPadding, 0);
    const ProjectArgs args{
        parameters.data(), parameters.stride(), parameters.size(), sh_degree_, view_,
        constants_,        splats_.data(),      visible_.data()};
    threads_.for_pieces(parameters.size(), kSplatPiece, [&](std::size_t begin, std::size_t end) {
      kernels_.project(args, begin, end);
    });
  }

  TileArgs tile_args(std::size_t tile) {
    const std::uint32_t first = lists_.first_entry[tile];
    const int column = static_cast<int>(tile) % lists_.tiles_x;
    const int line = static_cast<int>(tile) / lists_.tiles_x;
    return {splats_.data(),
            lists_.entries.data() + first,
            lists_.first_entry[tile + 1] - first,
            column * kTileSize,
            line * kTileSize,
            color_.width(),
            color_.height(),
            color_.pitch(),
            constants_,
            color_.plane(0),
            transmittance_.plane(0),
            nullptr,
            nullptr,
            nullptr,
            nullptr};
  }

  void blend(int width, int height) {
    ProfileScope scope(profiler_, "forward");
    if (color_.width() != width || color_.height() != height) {
      color_ = PlanarImage(width, height, 3);
      transmittance_ = PlanarImage(width, height, 1);
    }
    used_.resize(lists_.tiles());
    std::vector<std::uint64_t> pairs(count_pairs_ ? lists_.tiles() : 0);
    threads_.for_pieces(lists_.tiles(), 1, [&](std::size_t tile, std::size_t) {
      TileArgs args = tile_args(tile);
      if (count_pairs_) args.pairs = &pairs[tile];
      used_[tile] = kernels_.forward(args);
    });
    pixel_pairs_ = 0;
    for (std::uint64_t p : pairs) pixel_pairs_ += p;
  }

  /// Calls replay(arguments of a tile) for the entries of each tile that the last forward pass
  /// blended; it fills their `pairs`. Entries behind finished pixels were never blended: zeros.
  template <class Pair, class Replay>
  void replay_tiles(std::vector<Pair>& pairs, const Replay& replay) {
    pairs.resize(lists_.entries.size());
    threads_.for_pieces(lists_.tiles(), 1, [&](std::size_t tile, std::size_t) {
      TileArgs args = tile_args(tile);
      for (std::uint32_t e = used_[tile]; e < args.count; ++e) pairs[args.entries[e].slot] = {};
      args.count = used_[tile];
      replay(args);
    });
  }

  void backpropagate_tiles(const PlanarImage& color_gradient,
                           const PlanarImage* transmittance_gradient) {
    ProfileScope scope(profiler_, "backward");
    replay_tiles(pairs_, [&](TileArgs args) {
      args.color_gradient = color_gradient.plane(0);
      if (transmittance_gradient) args.transmittance_gradient = transmittance_gradient->plane(0);
      args.gradients = pairs_.data();
      kernels_.backward(args);
    });
  }

  /// Calls take(splat, sums) with the pairs of each visible splat, which consist of floats, added
  /// up in the fixed order of their slots.
  template <class Pair, class Take>
  void add_pairs(const std::vector<Pair>& pairs, const Take& take) {
    using Floats = std::array<float, sizeof(Pair) / sizeof(float)>;
    threads_.for_pieces(lists_.order.size(), kSplatPiece, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        Floats total{};
        for (std::uint32_t slot = lists_.first_slot[k]; slot < lists_.first_slot[k + 1]; ++slot) {
          const auto fields = std::bit_cast<Floats>(pairs[slot]);
          for (std::size_t f = 0; f < total.size(); ++f) total[f] += fields[f];
        }
        take(lists_.order[k], total);
      }
    });
  }

  void sum_pairs() {
    sums_.resize(splats_.size());
    add_pairs(pairs_, [&](std::uint32_t splat, const auto& total) {
      sums_[splat] = std::bit_cast<PairGradient>(total);
    });
  }

  /// Adds up each splat's pairs: one row for each of their floats.
  template <class Pair>
  void sum_fields(const std::vector<Pair>& pairs, PlanarFloats& rows) {
    add_pairs(pairs, [&](std::uint32_t splat, const auto& total) {
      for (std::size_t f = 0; f < total.size(); ++f) rows.row(f)[splat] = total[f];
    });
  }

  void chain_rule(const PlanarFloats& parameters) {
    if (gradient_.size() != parameters.size() || gradient_.rows() != parameters.rows()) {
      gradient_ = PlanarFloats(parameters.rows(), parameters.size());
      center_gradient_ = PlanarFloats(1, parameters.size());
    }
    const GradientArgs args{parameters.data(),
                            parameters.stride(),
                            parameters.size(),
                            sh_degree_,
                            view_,
                            splats_.data(),
                            sums_.data(),
                            gradient_.data(),
                            center_gradient_.data(),
                            visible_.data()};
    const std::size_t pieces = (parameters.size() + kSplatPiece - 1) / kSplatPiece;
    std::vector<std::uint32_t> rejected(pieces);
    threads_.for_pieces(parameters.size(), kSplatPiece, [&](std::size_t begin, std::size_t end) {
      rejected[begin / kSplatPiece] = kernels_.gradient(args, begin, end);
    });
    for (std::uint32_t r : rejected) rejected_ += r;
  }

  const Threads& threads_;
  Profiler& profiler_;
  const RasterKernels& kernels_;
  bool count_pairs_;

  // Of the last forward pass
  math::View<float> view_{};
  RasterConstants constants_{};
  int sh_degree_ = 0;
  std::vector<ProjectedSplat> splats_;
  std::vector<std::uint8_t> visible_;
  TileLists lists_;
  Binner binner_;
  PlanarImage color_, transmittance_;
  std::vector<std::uint32_t> used_;  // per tile: entries blended
  std::uint64_t pixel_pairs_ = 0;

  // Of the last score
  std::vector<PairScore> pair_scores_;
  PlanarFloats scores_;

  // Results of the last removal()
  std::vector<PairRemoval> pair_removals_;
  PlanarFloats removals_;

  // Of the last backward pass
  std::vector<PairGradient> pairs_;
  std::vector<PairGradient> sums_;
  PlanarFloats gradient_, center_gradient_;
  std::uint64_t rejected_ = 0;
};

}  // namespace

std::unique_ptr<Rasterizer> make_cpu_rasterizer(const Threads& threads, Profiler& profiler,
                                                const CpuRasterizerOptions& options) {
  return std::make_unique<CpuRasterizer>(threads, profiler, options);
}

}  // namespace fluxgs
