// Compact files of scenes whose colours the networks make.
#pragma once

#include "fluxgs/error.h"
#include "fluxgs/io/compact_glb.h"
#include "trainer/paper/appearance_model.h"

namespace fluxgs {

/// The networks as ONNX models, their constants and, with Ψ, the latents of every splat in the
/// order of the parameters. An error if a weight is not finite.
Expected<CompactNetworks> export_networks(const AppearanceModel& model,
                                          const PlanarFloats& latents);

/// The cloud to be stored with them: of degree 1, with canonical rotations; without Ψ its colours
/// are c′, with Ψ those of the parameters, which are not stored.
SplatCloud cloud_for_networks(const AppearanceModel& model, const PlanarFloats& parameters,
                              const PlanarFloats& latents);

}  // namespace fluxgs
