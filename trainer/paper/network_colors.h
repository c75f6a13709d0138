// Network colours: after the SH reduction, the paper's networks make the colours of the splats
// ("Monte Carlo Specular Energy Aggregator", "Gaussian Attribute Awareness").
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "trainer/compress/sh_reduction.h"
#include "trainer/model/phase.h"
#include "trainer/paper/appearance_pass.h"
#include "trainer/paper/energy_moments.h"

namespace fluxgs {

struct NetworkColorOptions {
  static constexpr const char* kTitle = "Network colours";
  Residual residual = Residual::from_1;  ///< of the energy moments
  bool psi = true;   ///< energy: a network makes c′; off: the projection of the energy is added
  bool phi = false;  ///< a network adds offsets (paper, "Gaussian Attribute Awareness")
  int psi_fit_iterations = 500;  ///< in which Ψ learns known colours before training goes on
  double psi_lr = 0.01;          ///< learning rate of Ψ, see NetworkRates
  double phi_lr = 1e-3;          ///< of Φ

  OptionFields fields(const TrainOptions& all);
  Expected<void> validate(const TrainOptions& all) const;
};

/// True if Ψ, and Φ, make colours; of valid options.
bool makes_psi(const TrainOptions& options);
bool makes_phi(const TrainOptions& options);

/// Names of the values attached to splats: what is trained in the place of their SH coefficients,
/// which then hold the networks' results for the splats last seen.
inline constexpr const char* kLatents = "latents";
inline constexpr const char* kLatentMoments[] = {"latents, first moments",
                                                 "latents, second moments"};

/// Energy moments, once known: 12 rows (energy_moments.h).
using SharedEnergy = std::shared_ptr<PlanarFloats>;

class NetworkColors final : public Phase {
 public:
  NetworkColors(const TrainOptions& options, int iteration, SharedEnergy energy,
                const Threads& threads);

  const char* name() const override { return "network colours"; }
  Period period() const override;
  std::string effect() const override;
  void before_render(Training& t) override;
  void after_backward(Training& t) override;
  bool reports(int iteration) const override { return iteration == iteration_; }
  PhaseWork work(int iteration, std::size_t views) const override {
    return {.renders = reports(iteration) ? static_cast<double>(views) : 0};
  }
  std::optional<PhaseReport> after_step(Training& t) override;
  bool has_colors() const override { return model_.has_value(); }
  void bake_colors(const TrainState& state, PlanarFloats& parameters) const override;
  std::uint64_t rejected_gradients() const override { return pass_.rejected_gradients(); }
  std::vector<double> save() const override;
  Expected<void> load(const std::vector<double>& values, const TrainState& state) override;

  /// The networks; none before the SH reduction.
  const std::optional<AppearanceModel>& model() const { return model_; }

 private:
  int latent_iterations(int iteration) const;

  NetworkColorOptions options_;
  bool psi_, phi_;  ///< which networks there are to be
  int iteration_, iterations_;
  std::uint64_t seed_;
  SharedEnergy energy_;
  const Threads& threads_;
  std::optional<AppearanceModel> model_;
  AppearancePass pass_;
  PlanarFloats latent_gradient_;
};

/// The phase that takes the energy moments before the SH reduction, and the one that makes colours
/// of them after it. Null where nothing of the kind is asked for. After make_sh_reduction().
struct NetworkColorPhases {
  std::unique_ptr<Phase> energy, colors;
};
NetworkColorPhases make_network_colors(TrainOptions& options, const Threads& threads);

}  // namespace fluxgs
