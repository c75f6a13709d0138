// Search for the quantization steps of a compact .glb: the smallest file for an error, or the
// smallest error for a size.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fluxgs/error.h"
#include "fluxgs/io/compact_glb.h"
#include "fluxgs/io/scene_file.h"
#include "fluxgs/splat_cloud.h"
#include "trainer/compress/scene_error.h"
#include "trainer/core/progress.h"
#include "trainer/core/psnr.h"

namespace fluxgs {

/// Name of compact files that exist in memory only, in error messages.
inline constexpr const char* kCompactFileName = "compact .glb";

/// A mean square error that no image shows, 80 dB: more bytes are of no use.
inline constexpr double kInvisibleMse = 1e-8;

/// A scene stored once.
struct CompactTrial {
  CompactOptions options;
  std::vector<std::byte> file;
  AttributeBits attribute_bits;
  double mse = 0;  ///< of its renders to those of the uncompressed scene

  double psnr() const { return psnr_of_mse(mse); }
};

class CompactSearch {
 public:
  /// `cloud` (finite) is stored; `shown` is the same but for colours that networks in `options`
  /// make of it, and what `error` is of. `cloud` and `error` must outlive this. `options` holds
  /// what is not searched for; its steps are where the search begins. `progress` follows
  /// within_loss() and within_bytes().
  CompactSearch(const SplatCloud& cloud, const SplatCloud& shown, const SceneError& error,
                CompactOptions options, ProgressReport progress = {});

  /// Takes a cloud that has its colours.
  CompactSearch(const SplatCloud& cloud, const SceneError& error, CompactOptions options,
                ProgressReport progress = {})
      : CompactSearch(cloud, cloud, error, std::move(options), std::move(progress)) {}

  /// Stores and measures.
  Expected<CompactTrial> trial(const QuantizationSteps& steps) const;

  /// Steps whose file is about as large as that of `steps`, moved towards where one more bit for
  /// any attribute buys the same error: the condition of Lagrange for the least error of all files
  /// of that size. Errors of different attributes are taken to add up.
  Expected<QuantizationSteps> balanced(const QuantizationSteps& steps) const;

  /// The smallest file found with psnr() ≥ `decibels`. The error is no smooth function of the
  /// steps, for quantization may swap which of two splats is in front; the file may therefore be
  /// some tenths of a decibel better than asked. An error if even very fine steps do not reach it.
  Expected<CompactTrial> within_loss(double decibels) const;

  /// The file with the smallest error found that has `bytes` at most, together with as many
  /// `beside` it. An error if even very coarse steps do not fit, which says how many bytes are
  /// needed.
  Expected<CompactTrial> within_bytes(std::size_t bytes, std::size_t beside = 0) const;

  /// A first look at that, in a fifth of the time: the proportions of the first steps stay, and the
  /// file may be 1% smaller than it might be.
  Expected<CompactTrial> first_within_bytes(std::size_t bytes, std::size_t beside = 0) const;

 private:
  struct Goal {
    bool coarser_fits = false;  ///< whether excess falls as steps grow
    double enough = 0;          ///< the mse at which images tell nothing more
    int balances = 0;           ///< of the steps, each with another search
    double tolerance = 0;       ///< excess below 0 by this much is not worth another trial
    double slope = 1;           ///< about by how much excess changes with the logarithm of steps
    std::function<double(const CompactTrial&)> excess;  ///< > 0: too much
    std::function<double(const CompactTrial&)> cost;    ///< to be made small
  };
  Expected<std::optional<CompactTrial>> solve(const QuantizationSteps& steps, const Goal& goal,
                                              CompactTrial& last,
                                              const ProgressReport& progress) const;
  Expected<CompactTrial> reach(const Goal& goal, CompactTrial& last) const;
  Expected<CompactTrial> search_bytes(std::size_t bytes, std::size_t beside, int balances,
                                      double tolerance) const;
  Expected<double> error_of(std::size_t part, const QuantizationSteps& steps,
                            const SplatCloud& exact, const SplatCloud& stored) const;

  const SplatCloud& cloud_;
  SplatCloud shown_;
  const SceneError& error_;
  CompactOptions options_;
  ProgressReport progress_;
  double finest_position_;
};

}  // namespace fluxgs
