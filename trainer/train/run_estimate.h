// Estimate of the time that a running training still takes, and of the splats and memory that it
// comes to. It is learned from the run: how long each stage of an iteration takes for its pixels
// and splats, and each phase for its work. The schedule says when there will be how much of both.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "trainer/train/trainer.h"

namespace fluxgs {

/// Work after the last iteration, and of measuring the test views meanwhile.
struct LaterWork {
  PhaseWork storing = {};
  double measuring_renders = 0;  ///< spread over all iterations
};

class RunEstimate {
 public:
  /// `trainer` must outlive it.
  RunEstimate(const Trainer& trainer, const LaterWork& later);

  /// After each iteration, in which so much wall time passed.
  void add(double seconds);

  /// Seconds of everything to come, storing included. 0 before the first iteration.
  double seconds_left() const { return forecast().seconds; }
  /// The most splats, from now on.
  double peak_splats() const { return forecast().splats; }
  /// Bytes that the program will have held at its largest.
  std::size_t peak_memory() const { return memory_of(forecast().splats); }

  /// Seconds of everything to come, and the most splats from now on.
  struct Forecast {
    double seconds = 0, splats = 0;
  };
  Forecast forecast() const;
  /// The same bytes, if there will be so many splats at most.
  std::size_t memory_of(double splats) const;

 private:
  /// Seconds and the units of work that they were for, both forgotten bit by bit.
  struct Rate {
    double seconds = 0, units = 0;
    double value() const { return units > 0 ? seconds / units : 0; }
  };
  /// Sizes that the time of an iteration depends on.
  struct Load {
    double pixels = 0, splats = 0;
    int sh_degree = 0;
  };
  struct Item {
    int iteration;
    const Phase* phase;
    PhaseWork work;
  };
  struct Learned {
    double actual = 0, predicted = 0;  ///< seconds of the work
    std::vector<double> growth;        ///< changes of the logarithm of the number of splats
    double factor() const;
    double growth_or(double expected) const;
  };

  double units_of(const std::string& stage, const Load& load) const;
  bool was_stopped(double seconds) const;
  void learn_stages(double seconds, const Load& load);
  void skip_stages();
  double measured_blend_power();
  int sh_degree(int iteration) const;
  double plain_seconds(int iteration, double splats) const;
  double render_seconds(int iteration, double splats) const;
  double work_seconds(const Item& item, double splats) const;
  double growth_of(const Item& item, bool limited) const;
  double growth_of_images() const;
  double pairs_at(double splats) const;

  const Trainer& trainer_;
  LaterWork later_;
  std::vector<Item> items_;             ///< by iteration
  std::size_t next_ = 0;                ///< the first that is to come
  double pixels_ = 0;                   ///< of a training image, the mean
  std::optional<double> blend_power_;   ///< growth of the time of blending with pixels, measured
  std::optional<double> by_gradients_;  ///< splats that the last densification had a reason for
  double elapsed_ = 0;
  double splats_before_ = 0;
  double pairs_ = 0;  ///< splat-tile pairs of a visible splat, the mean of the last iterations
  std::map<std::string, double> stages_before_;
  std::map<std::string, Rate> rates_;
  std::map<const Phase*, Learned> learned_;
  double file_seconds_ = 0;  ///< for a value of a splat; 0 before it was measured
};

}  // namespace fluxgs
