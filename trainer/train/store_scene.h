// Stores a trained state as a compact file.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "fluxgs/error.h"
#include "trainer/compress/compact_search.h"
#include "trainer/train/trainer.h"

namespace fluxgs {

struct StoredScene {
  std::vector<std::byte> file;  ///< a compact .glb
  SplatCloud cloud;             ///< what it holds, colours made by networks included
  /// Bytes of files with the same error: with networks, and with the colours that they make. None
  /// where nothing was made by networks, or where there is an error.
  std::optional<std::size_t> with_networks = {}, without_networks = {};
  /// Reason why there is no file with networks: they cannot be run (no onnxruntime), or no steps
  /// are fine enough. Colours are then stored.
  std::optional<Error> networks_error = {};
};

/// The state as a compact file: the file of a phase that has decided how it is quantized, otherwise
/// the smallest one that is found with Trainer::compressed_psnr(). Networks go into it only if it
/// is then smaller than with the colours that they make. Errors name the attribute; a stop is one.
Expected<StoredScene> store_scene(const Trainer& trainer, const std::vector<View>& views,
                                  const Threads& threads, const WorkControl& control = {});

}  // namespace fluxgs
